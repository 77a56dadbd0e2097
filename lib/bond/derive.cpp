#include "bond/derive.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "base/mutant.hpp"

namespace veriflex::bond {

namespace {

constexpr std::array tolerances{0.01, 0.05, 0.10};
constexpr double max_strain = 9.0;  // how far a law without a longest length is followed
constexpr int scan_cells = 4000;    // per smooth piece

// An interval of lengths in which the tension changes sign from push to pull.
template <BondLaw Law>
Interval bracket_rest(const Law& law, const Function& tension) {
  const double shortest = law.domain().lo;
  const double longest = law.domain().hi;
  const auto shorter = [&](double r) { return shortest > 0.0 ? 0.5 * (r + shortest) : 0.8 * r; };
  const auto longer = [&](double r) { return std::isfinite(longest) ? 0.5 * (r + longest) : 1.25 * r; };
  double lo = law.typical_length();
  double hi = lo;
  for (int i = 0; i < 200 && admits(law, lo) && !(tension(lo) <= 0.0); ++i) lo = shorter(lo);
  for (int i = 0; i < 200 && admits(law, hi) && !(tension(hi) >= 0.0); ++i) hi = longer(hi);
  if (!admits(law, lo) || !admits(law, hi) || !(law.tension(lo) <= 0.0) || !(law.tension(hi) >= 0.0)) {
    throw BadParameter("law", fmt::format("no rest length found for bond law {}", Law::name),
                       "its tension does not change sign in its domain, or leaves double precision",
                       "Look at the size of its parameters");
  }
  return {lo, hi};
}

template <BondLaw Law>
double rest_length(const Law& law, const Function& tension) {
  const Interval bracket = bracket_rest(law, tension);
  double r = bracketed_root(tension, bracket.lo, bracket.hi);
  // Newton's steps to the last bit: stop when the residual no longer shrinks.
  for (int i = 0; i < 10; ++i) {
    const double better = r - tension(r) / law.stiffness(r);
    if (!admits(law, better) || !(std::abs(tension(better)) < std::abs(tension(r)))) break;
    r = better;
  }
  for (const double neighbour : {std::nextafter(r, bracket.lo), std::nextafter(r, bracket.hi)}) {
    if (admits(law, neighbour) && std::abs(tension(neighbour)) < std::abs(tension(r))) r = neighbour;
  }
  // A sign change at a jump of the tension is no rest state.
  if (!(std::abs(law.tension(r)) <= 1e-9 * std::abs(law.stiffness(r)) * r)) {
    throw BadParameter("cutoff", fmt::format("bond law {} has no rest length", Law::name),
                       fmt::format("its tension jumps through zero at r = {}", r),
                       "A cut-off must lie above the rest length");
  }
  if (!(law.stiffness(r) > 0.0) || !std::isfinite(law.stiffness(r) / r)) {
    throw NumericalFailure(fmt::format("bond law {}: stiffness {} at r = {} is not positive and finite",
                                       Law::name, law.stiffness(r), r),
                           FailureMode::Bond);
  }
  return planted(Mutant::rest_length_rounded) ? std::round(1e4 * r) / 1e4 : r;
}

template <BondLaw Law>
std::vector<double> kink_lengths(const Law& law) {
  std::vector<double> lengths;
  if constexpr (HasKinks<Law>) {
    for (const double r : law.kinks()) {
      if (admits(law, r)) lengths.push_back(r);
    }
  }
  std::sort(lengths.begin(), lengths.end());
  return lengths;
}

double below(double r) { return std::nextafter(r, 0.0); }

// The smooth pieces of the law between rest and `end` (either side), in the order they are met going
// outwards. Each is closed and lies strictly inside the law's domain and on one side of every kink.
template <BondLaw Law>
std::vector<Interval> pieces_from_rest(const Law& law, double rest, double end) {
  std::vector<Interval> pieces;
  double start = rest;
  std::vector<double> kinks = kink_lengths(law);
  if (end > rest) {
    for (const double kink : kinks) {
      if (kink <= rest || kink >= end) continue;
      pieces.push_back({start, below(kink)});
      start = kink;
    }
    pieces.push_back({start, below(end)});
  } else {
    std::reverse(kinks.begin(), kinks.end());
    for (const double kink : kinks) {
      if (kink >= rest || kink <= end) continue;
      pieces.push_back({start, kink});
      start = below(kink);
    }
    pieces.push_back({start, std::nextafter(end, rest)});
  }
  return pieces;
}

// The first length, going outwards from rest, at which |ratio - 1| exceeds the tolerance; the end of the
// domain if it never does.
template <BondLaw Law>
double first_departure(const Law& law, double rest, double domain_end, double tolerance,
                       const Function& ratio) {
  const double end = std::isfinite(domain_end) ? domain_end : rest * (1.0 + max_strain);
  const Function excess = [&](double r) { return std::abs(ratio(r) - 1.0) - tolerance; };
  for (const Interval& piece : pieces_from_rest(law, rest, end)) {
    double inner = piece.lo;
    if (excess(inner) > 0.0) return inner;  // the jump at a kink left the range
    for (int i = 1; i <= scan_cells; ++i) {
      const double outer = i == scan_cells ? piece.hi : piece.lo + (piece.hi - piece.lo) * i / scan_cells;
      const double at_outer = excess(outer);
      if (at_outer > 0.0 || std::isnan(at_outer)) {
        // Next to the domain's end the law may overflow: shrink to the finite part first.
        // Sixty halvings come down to the last bit.
        double finite = outer;
        for (int halving = 0; halving < 60 && !std::isfinite(excess(finite)); ++halving)
          finite = 0.5 * (finite + inner);
        return excess(finite) > 0.0 ? bracketed_root(excess, std::min(inner, finite), std::max(inner, finite))
                                    : finite;
      }
      inner = outer;
    }
  }
  return domain_end;
}

template <BondLaw Law>
Interval valid_strains(const Law& law, double rest, double tolerance, const Function& ratio) {
  const auto strain = [rest](double r) { return (r - rest) / rest; };
  return {strain(first_departure(law, rest, law.domain().lo, tolerance, ratio)),
          strain(first_departure(law, rest, law.domain().hi, tolerance, ratio))};
}

struct Least {
  double ratio;
  double strain;
};

template <BondLaw Law>
Least min_tangent_in_tension(const Law& law, double rest, double k0) {
  const auto ratio = [&](double r) { return law.stiffness(r) / k0; };
  const double end = std::isfinite(law.domain().hi) ? law.domain().hi : rest * (1.0 + max_strain);
  Least least{1.0, 0.0};
  const auto consider = [&](double r) {
    if (ratio(r) < least.ratio) least = {ratio(r), (r - rest) / rest};
  };
  for (const auto& [lo, hi] : pieces_from_rest(law, rest, end)) {
    const auto point = [&, a = lo, b = hi](int i) {
      return i == scan_cells ? b : a + (b - a) * i / scan_cells;
    };
    for (int i = 0; i <= scan_cells; ++i) {
      consider(point(i));
      const bool dips = i > 0 && i < scan_cells && ratio(point(i)) < ratio(point(i - 1)) &&
                        ratio(point(i)) < ratio(point(i + 1));
      if (dips) consider(bracketed_minimum(ratio, point(i - 1), point(i), point(i + 1)));
    }
  }
  return least;
}

template <BondLaw Law>
double smooth_radius(const Law& law, double rest) {
  double radius = rest - law.domain().lo;
  radius = std::min(radius, law.domain().hi - rest);
  for (const double kink : kink_lengths(law)) radius = std::min(radius, std::abs(kink - rest));
  return radius;
}

// Central differences of the tension, narrow against all that changes near rest. GSL's width only shrinks.
template <BondLaw Law>
Derivative stiffness_by_differences(const Law& law, double rest, double radius) {
  const double width = std::min(1e-3 * rest, 0.01 * radius);
  if (!(width > 1e3 * std::numeric_limits<double>::epsilon() * rest)) {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    return {none, none};
  }
  return central_derivative([&](double r) { return law.tension(r); }, rest, width);
}

template <BondLaw Law>
Derivation derive_law(const Law& law) {
  Derivation d{};
  const double rest = rest_length(law, [&](double r) { return law.tension(r); });
  const double k0 = law.stiffness(rest);
  d.rest_length = rest;
  d.stiffness = k0;
  d.force_per_strain = k0 * rest;
  d.young_modulus = k0 / (planted(Mutant::young_modulus_without_spacing) ? 1.0 : rest);
  for (const Parameter<Law>& p : Law::parameters()) {
    if (p.name == "fene_k") d.stiffness_over_fene_k = k0 / law.*p.member;
  }
  if (std::isfinite(law.domain().hi)) d.strain_at_r_max = (law.domain().hi - rest) / rest;

  for (const double r : kink_lengths(law)) {
    d.kinks.push_back({.length = r,
                       .strain = (r - rest) / rest,
                       .tension_jump = law.tension(r) - law.tension(below(r)),
                       .tangent_below = law.stiffness(below(r)) / k0,
                       .tangent_above = law.stiffness(r) / k0});
  }
  const Least least = min_tangent_in_tension(law, rest, k0);
  d.min_tangent_ratio = least.ratio;
  d.min_tangent_strain = least.strain;

  const Function tangent = [&](double r) { return law.stiffness(r) / k0; };
  const Function secant = [&](double r) { return r == rest ? 1.0 : law.tension(r) / (k0 * (r - rest)); };
  for (const double tolerance : tolerances) {
    d.validity.push_back(
        {tolerance,
         valid_strains(law, rest, tolerance, planted(Mutant::secant_range_of_tangent) ? tangent : secant),
         valid_strains(law, rest, tolerance, tangent)});
  }
  d.smooth_radius = smooth_radius(law, rest);
  d.stiffness_by_differences = stiffness_by_differences(law, rest, d.smooth_radius);
  return d;
}

}  // namespace

Derivation derive(const AnyLaw& law) {
  return std::visit([](const auto& l) { return derive_law(l); }, law);
}

std::vector<double> rest_length_search(const AnyLaw& law) {
  std::vector<double> asked;
  std::visit(
      [&](const auto& l) {
        rest_length(l, [&](double r) {
          asked.push_back(r);
          return l.tension(r);
        });
      },
      law);
  return asked;
}

AtLength derive_at(const AnyLaw& law, double length) {
  const double k = stiffness(law, length);
  return {k * length, k / length};
}

Calibration calibrate(const AnyLaw& prototype, double young, double spacing, double poisson) {
  require_positive("young", young);
  require_positive("spacing", spacing);
  if (!(poisson > -1.0) || !std::isfinite(poisson)) {
    throw BadParameter("poisson", fmt::format("Poisson's ratio is {}", poisson),
                       "the shear modulus E/(2 (1 + nu)) must be positive and finite",
                       "Give a number above -1");
  }
  const Derivation of_prototype = derive(prototype);
  const double length = spacing / of_prototype.rest_length;
  const double energy = young / of_prototype.young_modulus * length * length *
                        (planted(Mutant::calibrated_energy_by_area) ? 1.0 : length);
  const double angle_stiffness =
      spacing * spacing * spacing * young /
      ((planted(Mutant::angle_stiffness_of_full_shear) ? 4.0 : 8.0) * (1.0 + poisson));
  const auto fail_beyond_doubles = [&](std::string_view what, double value) {
    throw BadParameter(
        "spacing", fmt::format("'{}' would be {}", what, value),
        fmt::format("a modulus of {} at a spacing of {} leaves double precision", young, spacing),
        "Choose units in which lengths and moduli are nearer to 1");
  };
  if (!std::isnormal(angle_stiffness)) fail_beyond_doubles("angle_stiffness", angle_stiffness);
  for (const NamedValue& p : parameters_of(prototype)) {
    const double value =
        p.value * std::pow(energy, p.dimension.energy) * std::pow(length, p.dimension.length);
    if (std::isfinite(p.value) && !std::isnormal(value)) fail_beyond_doubles(p.name, value);
  }
  const AnyLaw law = rescaled(prototype, energy, length);
  return {law, angle_stiffness, derive(law)};
}

}  // namespace veriflex::bond
