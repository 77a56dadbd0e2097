/// An open interval of the real line.
#pragma once

namespace veriflex {

struct Interval {
  double lo;
  double hi;
  bool contains(double x) const { return lo < x && x < hi; }
};

}  // namespace veriflex
