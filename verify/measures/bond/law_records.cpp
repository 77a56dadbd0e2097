#include "measures/bond/law_records.hpp"

namespace veriflex::measures {

observe::Record validity_record() {
  return {"validity",
          "Strains around zero in which the law is linear within a tolerance",
          {{"tolerance", "", "1", "largest deviation of the ratio from 1", {}},
           {"secant_lo", "", "1", "least strain: stress / (E strain) within the tolerance", {}},
           {"secant_hi", "", "1", "largest strain: stress / (E strain) within the tolerance", {}},
           {"tangent_lo", "", "1", "least strain: U''(r)/U''(r_eq) within the tolerance", {}},
           {"tangent_hi", "", "1", "largest strain: U''(r)/U''(r_eq) within the tolerance", {}}}};
}

void record_validity(const bond::Derivation& derivation, observe::Record& record) {
  for (const bond::Validity& v : derivation.validity) {
    record.append({v.tolerance, v.secant.lo, v.secant.hi, v.tangent.lo, v.tangent.hi});
  }
}

}  // namespace veriflex::measures
