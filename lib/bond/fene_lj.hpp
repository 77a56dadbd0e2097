/// FENE attraction plus cut-off Lennard-Jones repulsion (the bond of the GLNSM).
/// [wu-qi-2014, Eqs. 16-20]
///
///   U(r) = -1/2 K R0^2 ln(1 - (r/R0)^2) + [4 eta ((sigma/r)^12 - (sigma/r)^6) - U_LJ(Rc)]  for r < Rc,
///          the first term alone beyond Rc
///
/// Defined for 0 < r < R0. The paper gives no Rc (departure D4: default 2^(1/6) sigma, where the LJ force
/// vanishes) and no shift (D5: U is continuous at Rc); its printed Eq. 17 lacks the square on R0 (the
/// force of its Appendix A has it).
#pragma once

#include <cmath>

#include "base/error.hpp"
#include "base/mutant.hpp"
#include "bond/bond_law.hpp"

namespace veriflex::bond {

struct FeneLj {
  double epsilon;  // eta    [M L^2 T^-2]
  double sigma;    // sigma  [L]
  double fene_k;   // K      [M T^-2]; not the bond's stiffness, see derive.hpp
  double r_max;    // R0     [L]
  double cutoff;   // Rc     [L]; infinity keeps the whole Lennard-Jones term

  static constexpr double lj_minimum = 1.122462048309372981433533;  // 2^(1/6), in units of sigma
  static constexpr std::string_view name = "fene-lj";
  static constexpr auto parameters() {
    return std::array{
        Parameter<FeneLj>{"epsilon", "eta", &FeneLj::epsilon, {1, 0}, "depth of the Lennard-Jones well"},
        Parameter<FeneLj>{"sigma", "", &FeneLj::sigma, {0, 1}, "where the Lennard-Jones term is zero"},
        Parameter<FeneLj>{"fene_k",
                          "K",
                          &FeneLj::fene_k,
                          {1, -2},
                          "FENE coefficient; default 30 epsilon / sigma^2",
                          [](const FeneLj& b) {
                            return 30.0 * b.epsilon /
                                   (b.sigma * (planted(Mutant::fene_k_without_square) ? 1.0 : b.sigma));
                          }},
        Parameter<FeneLj>{"r_max",
                          "R0",
                          &FeneLj::r_max,
                          {0, 1},
                          "length that is never reached; default 1.5 sigma",
                          [](const FeneLj& b) { return 1.5 * b.sigma; }},
        Parameter<FeneLj>{"cutoff",
                          "Rc",
                          &FeneLj::cutoff,
                          {0, 1},
                          "end of the Lennard-Jones term, inf for none; default 2^(1/6) sigma",
                          [](const FeneLj& b) { return lj_minimum * b.sigma; }},
    };
  }

  double energy(double r) const {
    const double x = r / r_max;
    const double fene =
        -0.5 * fene_k * r_max * (planted(Mutant::fene_r_max_not_squared) ? 1.0 : r_max) * std::log1p(-x * x);
    return r < cutoff
               ? fene + lj_energy(r) -
                     (std::isinf(cutoff) || planted(Mutant::lj_shift_dropped) ? 0.0 : lj_energy(cutoff))
               : fene;
  }
  double tension(double r) const {
    const double x = r / r_max;
    const double fene = fene_k * r / ((1.0 - x) * (1.0 + x));
    const double s6 = sixth_power(sigma / r);
    const double lj =
        24.0 * epsilon / r * ((planted(Mutant::lj_repulsion_halved) ? 1.0 : 2.0) * s6 * s6 - s6);
    return r < cutoff || planted(Mutant::lj_cutoff_dropped)
               ? fene - lj
               : fene;  // without a branch, so that loops become vector instructions
  }
  double stiffness(double r) const {
    const double x = r / r_max;
    const double gap = (1.0 - x) * (1.0 + x);
    const double fene = fene_k * (1.0 + x * x) / (gap * (planted(Mutant::fene_stiffness_gap) ? 1.0 : gap));
    if (r >= cutoff) return fene;
    const double s6 = sixth_power(sigma / r);
    return fene + 24.0 * epsilon / (r * r) * (26.0 * s6 * s6 - 7.0 * s6);
  }
  Interval domain() const { return {0.0, r_max}; }
  double typical_length() const { return sigma < r_max ? sigma : 0.5 * r_max; }
  std::array<double, 1> kinks() const { return {cutoff}; }
  void check() const {
    require_positive("epsilon", epsilon);
    require_positive("sigma", sigma);
    require_positive("fene_k", fene_k);
    require_positive("r_max", r_max);
    if (!(cutoff > 0.0)) {
      throw BadParameter("cutoff", "cutoff is not positive",
                         "it is a length; inf keeps the whole Lennard-Jones term",
                         "Leave it out for the default 2^(1/6) sigma");
    }
  }

 private:
  static double sixth_power(double s) {
    const double s3 = s * s * s;
    return s3 * s3;
  }
  double lj_energy(double r) const {
    const double s6 = sixth_power(sigma / r);
    return 4.0 * epsilon * (s6 * s6 - s6);
  }
};
static_assert(BondLaw<FeneLj> && HasKinks<FeneLj>);

}  // namespace veriflex::bond
