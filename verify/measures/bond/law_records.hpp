/// What every study of a bond law reports of it.
#pragma once

#include "bond/derive.hpp"
#include "observe/record.hpp"

namespace veriflex::measures {

/// Record `validity`, without rows: the strain intervals in which a law is as good as linear.
observe::Record validity_record();
void record_validity(const bond::Derivation& derivation, observe::Record& record);

}  // namespace veriflex::measures
