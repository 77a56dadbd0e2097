// Exact solutions of channel flow against what defines them.
#include "analytic/channel.hpp"
#include "catch.hpp"
#include "measures/fluid/norms.hpp"

using namespace veriflex;
using namespace veriflex::analytic;

TEST_CASE("The slip of half-way bounce-back vanishes at 1/2 + sqrt(3)/4 only, and is a quarter at tau = 1") {
  CHECK(std::abs(half_way_slip(0.5 + std::sqrt(3.0) / 4.0)) < 1e-15);
  CHECK(half_way_slip(1.0) == 0.25);
  CHECK(half_way_slip(0.6) < 0.0);
}

TEST_CASE("The duct's series solves Poisson's equation with zero at the walls, and has the known top") {
  const double h = 1e-3;
  for (const auto& [y, z] : {std::pair{0.5, 0.5}, {0.2, 0.7}, {0.05, 0.9}}) {
    const double laplacian =
        (square_duct(y + h, z, 1.0) + square_duct(y - h, z, 1.0) + square_duct(y, z + h, 1.0) +
         square_duct(y, z - h, 1.0) - 4.0 * square_duct(y, z, 1.0)) /
        (h * h);
    CHECK(laplacian == Approx(-1.0).epsilon(1e-4));
    CHECK(square_duct(y, z, 1.0) == Approx(square_duct(z, y, 1.0)).epsilon(1e-12));
  }
  CHECK(std::abs(square_duct(0.0, 0.3, 1.0)) < 1e-15);
  CHECK(std::abs(square_duct(0.3, 1e-12, 1.0)) < 1e-10);
  CHECK(square_duct(0.5, 0.5, 1.0) == Approx(0.0736713).epsilon(1e-6));
  CHECK(square_duct(4.0, 4.0, 8.0) == Approx(64.0 * 0.0736713).epsilon(1e-6));
}

TEST_CASE("Slow oscillation is Poiseuille's parabola, fast oscillation the force alone") {
  const double nu = 0.1;
  const std::complex<double> slow = oscillating_poiseuille(3.0, 10.0, 1e-8, nu);
  CHECK(slow.real() == Approx(plane_poiseuille(3.0, 10.0) / nu).epsilon(1e-6));
  const double omega = 100.0;
  const std::complex<double> fast = oscillating_poiseuille(5.0, 10.0, omega, nu) * omega;
  CHECK(std::abs(fast - std::complex<double>(0.0, -1.0)) < 1e-6);
  CHECK(std::abs(oscillating_poiseuille(0.0, 10.0, 0.1, nu)) < 1e-12);
}

TEST_CASE("The series for arrays agree with the published tables, and dilute spheres with Stokes") {
  CHECK(cylinder_array_drag(0.05) == Approx(15.56).epsilon(1e-3));
  CHECK(cylinder_array_drag(0.10) == Approx(24.83).epsilon(1e-3));
  CHECK(sphere_array_drag(0.001) == Approx(1.212).epsilon(1e-3));
  CHECK(sphere_array_drag(0.027) == Approx(2.008).epsilon(1e-3));
  CHECK(sphere_array_drag(0.064) == Approx(2.810).epsilon(1e-3));
  CHECK(sphere_array_drag(0.125) == Approx(4.292).epsilon(1e-3));
  CHECK(sphere_array_drag(1e-12) == Approx(1.0).epsilon(1e-3));
}

TEST_CASE("Error norms are relative to those of the exact values, and keep what is not a number") {
  const std::vector<double> exact{3.0, 4.0};
  const std::vector<double> measured{3.0, 4.5};
  const measures::Norms norms = measures::error_norms(measured, exact);
  CHECK(norms.l1 == Approx(0.5 / 7.0));
  CHECK(norms.l2 == Approx(0.1));
  CHECK(norms.linf == Approx(0.125));
  const std::vector<double> broken{NAN, 4.0};
  CHECK(std::isnan(measures::error_norms(broken, exact).linf));
}
