// Exact oscillating flows against what defines them, and bodies whose motion is given.
#include <numbers>

#include "analytic/immersed.hpp"
#include "analytic/stokeslet_rings.hpp"
#include "catch.hpp"
#include "scene/prescribed_body.hpp"

using namespace veriflex;
using Complex = std::complex<double>;
using std::numbers::pi;

TEST_CASE("K0 and K1 have the tabulated values, on the real axis and as Kelvin's functions") {
  CHECK(analytic::bessel_k(0, 1.0).real() == Approx(0.42102443824070834).epsilon(1e-13));
  CHECK(analytic::bessel_k(1, 1.0).real() == Approx(0.60190723019723457).epsilon(1e-13));
  CHECK(analytic::bessel_k(0, 0.1).real() == Approx(2.4270690247020166).epsilon(1e-13));
  const Complex kelvin = analytic::bessel_k(0, std::polar(1.0, pi / 4.0));  // ker 1 + i kei 1
  CHECK(kelvin.real() == Approx(0.2867062087283160).epsilon(1e-12));
  CHECK(kelvin.imag() == Approx(-0.4949946365187199).epsilon(1e-12));
}

TEST_CASE("K1 is the negative slope of K0") {
  for (const double size : {0.05, 0.5, 5.0, 40.0}) {
    const Complex z = std::polar(size, pi / 4.0);
    const double h = 1e-4 * std::min(size, 1.0);
    const Complex slope = (analytic::bessel_k(0, z + h) - analytic::bessel_k(0, z - h)) / (2.0 * h);
    CHECK(std::abs(slope / analytic::bessel_k(1, z) + 1.0) < 1e-6);
  }
}

TEST_CASE("The plate's flow has its velocity, and its shear stress on both sides is the force") {
  const double height = 20.0, omega = 0.02, nu = 0.1, h = 1e-4;
  CHECK(std::abs(analytic::oscillating_plate(0.0, height, omega, nu) - 1.0) < 1e-15);
  CHECK(std::abs(analytic::oscillating_plate(3.0, height, omega, nu) -
                 analytic::oscillating_plate(17.0, height, omega, nu)) < 1e-15);
  const Complex slope = (analytic::oscillating_plate(h, height, omega, nu) - 1.0) / h;
  CHECK(std::abs(-2.0 * nu * slope / analytic::oscillating_plate_force(height, omega, nu) - 1.0) < 1e-4);
}

TEST_CASE("Fast, a cylinder has its added mass and the drag of plates, and slow it has Stokes' logarithm") {
  const double a = 3.0, nu = 0.1;
  const double fast = 1e3;
  const Complex k = std::sqrt(Complex(0.0, fast / nu));
  const Complex boundary_layer = Complex(0.0, fast) * pi * a * a * (1.0 + 4.0 / (k * a));
  CHECK(std::abs(analytic::oscillating_cylinder_force(a, fast, nu) / boundary_layer - 1.0) < 1e-4);
  const double slow = 1e-8;
  const Complex z = a * std::sqrt(Complex(0.0, slow / nu));
  const Complex logarithm = 4.0 * pi * nu / (-std::log(0.5 * z) - 0.5772156649015329);
  CHECK(std::abs(analytic::oscillating_cylinder_force(a, slow, nu) / logarithm - 1.0) < 1e-4);
}

TEST_CASE(
    "Images far beyond the Stokes layer return half the cell's momentum, near ones move the whole cell") {
  const double nu = 0.1;
  const auto momentum = [](double side, double omega) { return 1.0 / (Complex(0.0, omega) * side * side); };
  CHECK(std::abs(analytic::backflow_of_images(100.0, 1.0, nu) / momentum(100.0, 1.0) - 0.5) < 1e-12);
  const double omega = 1e-6;  // the layer is 450 thick
  CHECK(std::abs(analytic::backflow_of_images(20.0, omega, nu) / momentum(20.0, omega) - 1.0) < 2e-3);
}

TEST_CASE(
    "A plate of markers is one without thickness when its Stokes layer is thick, with any kernel and "
    "forcing iterations") {
  const std::vector<double> hat{0.5, 0.25, 0.0, 0.0, 0.0, 0.0, 0.0, 0.25};
  std::vector<double> weights(4000, 0.0);
  std::copy(hat.begin(), hat.begin() + 2, weights.begin());
  weights.back() = 0.25;
  const double omega = 1e-7, nu = 0.1;
  const Complex thin = analytic::oscillating_plate_force(4000.0, omega, nu);
  CHECK(std::abs(analytic::marker_plate_force(weights, 1, omega, nu) / thin - 1.0) < 2e-3);
  CHECK(std::abs(analytic::marker_plate_force(weights, 9, omega, nu) / thin - 1.0) < 2e-3);
}

TEST_CASE("Doubling a box adds sound as the continuum's logarithm says") {
  const double omega = 1e-4, c2 = 1.0 / 3.0;  // sound far longer than the box
  const Complex more = analytic::compression_of_box(128.0, 3.0, omega, c2) -
                       analytic::compression_of_box(64.0, 3.0, omega, c2);
  CHECK(std::abs(more / (Complex(0.0, omega) * std::log(2.0) / (4.0 * pi * c2)) - 1.0) < 0.02);
}

namespace {

Positions ring(double radius, int count, double z, double centre) {
  Positions markers(count, 3);
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * pi * i / count;
    markers.row(i) << centre + radius * std::cos(angle), centre + radius * std::sin(angle), z;
  }
  return markers;
}

}  // namespace

TEST_CASE("Rings of oscillating forces all along an axis drag like a cylinder filled with fluid") {
  // Slowly, where the force of a cylinder is spread evenly around it; quickly the pressure is not.
  const double radius = 2.5, omega = 1e-4, viscosity = 1.0 / 6.0;
  std::complex<double> velocity = analytic::ring_on_ring(0.0, radius, 1.0, omega, viscosity);
  for (int k = 1; k < 2000; ++k) velocity += 2.0 * analytic::ring_on_ring(k, radius, 1.0, omega, viscosity);
  const std::complex<double> force = analytic::oscillating_cylinder_force(radius, omega, viscosity) +
                                     std::complex<double>(0.0, omega * pi * radius * radius);
  CHECK(std::abs(velocity * force - 1.0) < 2e-3);
}

TEST_CASE("What the fluid loses in a step the body has got") {
  const fluid::Spec spec{.grid = {{12, 10, 8}}, .relaxation_time = 0.8};
  const auto fluid = fluid::make_fluid(spec);
  scene::PrescribedBody body(spec, {.forcing_iterations = 3});
  Vec3 got = Vec3::Zero();
  for (int step = 0; step < 50; ++step) {
    body.place(ring(2.3, 14, 3.7, 4.0 + 0.05 * step));
    body.advance(*fluid, {0.05, 0.05, 0.0});
    got += body.total_force();
  }
  CHECK(got.norm() > 1e-2);
  CHECK((fluid->totals().momentum + got).norm() < 1e-13 * 50);
}

TEST_CASE("A marker takes from the fluid at rest its volume times its velocity") {
  const fluid::Spec spec{.grid = {{12, 10, 8}}, .relaxation_time = 0.8};
  const auto fluid = fluid::make_fluid(spec);
  const double volume = 0.7;
  scene::PrescribedBody body(spec, {.marker_volume = volume});
  body.place(ring(2.3, 14, 3.7, 4.0));
  const Vec3 velocity(0.05, 0.0, -0.02);
  body.advance(*fluid, velocity);
  for (Eigen::Index marker = 0; marker < 14; ++marker)
    CHECK((body.force().row(marker).transpose() + volume * velocity).norm() < 1e-16);
}

TEST_CASE("A box of one node along a cylinder is a slice of a longer one") {
  Vec3 force[2];
  for (const int nodes : {1, 5}) {
    const fluid::Spec spec{.grid = {{16, 16, nodes}}, .relaxation_time = 0.9};
    const auto fluid = fluid::make_fluid(spec);
    scene::PrescribedBody body(spec, {});
    Positions markers(12 * nodes, 3);
    for (int z = 0; z < nodes; ++z) markers.middleRows(12 * z, 12) = ring(2.2, 12, z, 7.6);
    body.place(markers);
    for (int step = 0; step < 60; ++step) body.advance(*fluid, {0.01, 0.0, 0.0});
    force[nodes / 5] = body.total_force() / nodes;
  }
  CHECK(force[0].norm() > 1e-3);
  CHECK((force[0] - force[1]).norm() < 1e-12);
}

TEST_CASE("Rounds of forcing leave less slip in the fluid at rest, and half of what a step corrects stays") {
  const fluid::Spec spec{.grid = {{12, 12, 12}}, .relaxation_time = 1.0};
  double slip_after = INFINITY;
  for (const int iterations : {1, 2, 4, 64}) {
    const auto fluid = fluid::make_fluid(spec);  // at rest: the first step finds the slip - U everywhere
    scene::PrescribedBody body(spec, {.forcing_iterations = iterations});
    body.place(ring(2.5, 15, 6.0, 6.0));
    body.advance(*fluid, {0.01, 0.0, 0.0});
    CHECK((body.slip().col(0).array() + 0.01).abs().maxCoeff() < 1e-16);
    // sum f c after the force: the fluid's velocity and the other half of the force
    const double left = (2.0 * body.slip_of_fluid() - body.slip()).norm();
    CHECK(left < slip_after);
    slip_after = left;
    CHECK((body.slip_of_fluid() - body.slip()).norm() < 0.5 * body.slip().norm() + 1e-12);
  }
  CHECK(slip_after < 1e-3);
}
