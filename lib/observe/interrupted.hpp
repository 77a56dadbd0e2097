/// A run that left its validity after it had measured something.
#pragma once

#include "base/error.hpp"
#include "observe/record.hpp"

namespace veriflex::observe {

/// Why a run ended, with what was seen until then: its last good state and all before it. Nothing in it is
/// judged; the result file keeps it beside the verdict `error`.
class Interrupted : public NumericalFailure {
 public:
  Interrupted(const NumericalFailure& why, Observations until_then)
      : NumericalFailure(why), seen(std::move(until_then)) {}
  Observations seen;
};

}  // namespace veriflex::observe
