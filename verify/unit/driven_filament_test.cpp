// A filament driven at one end: the published thrust and its limits, and chains of markers that tend to it.
#include "analytic/driven_filament.hpp"

#include <cmath>
#include <memory>
#include <numbers>

#include "catch.hpp"
#include "coupling/transfer.hpp"
#include "fluid/fluid.hpp"

using namespace veriflex;
using namespace veriflex::analytic;
using std::numbers::pi;
using std::numbers::sqrt2;

namespace {

/// Spheres that overlap their neighbours, a spacing apart in an unbounded fluid of viscosity 1, as Rotne and
/// Prager's tensor moves them.
Mobility spheres(Eigen::Index count, double radius) {
  Mobility m{Eigen::VectorXd(count), Eigen::VectorXd(count), Eigen::VectorXd(count)};
  const double self = 1.0 / (6.0 * pi * radius);
  m.along[0] = m.across[0] = self;
  m.turned[0] = 0.0;
  for (Eigen::Index d = 1; d < count; ++d) {
    const auto r = static_cast<double>(d);
    const double near = self * 3.0 / (32.0 * radius), far = 1.0 / (8.0 * pi * r);
    const double square = radius * radius / (r * r);
    const bool apart = r >= 2.0 * radius;
    m.across[d] = apart ? far * (1.0 + 2.0 / 3.0 * square) : self - 3.0 * near * r;
    m.turned[d] = apart ? far / r * (1.0 - 2.0 * square) : near;
    m.along[d] = m.across[d] + r * m.turned[d];
  }
  return m;
}

OscillatingMobility without_delay(const Mobility& m) {
  return {m.along.cast<std::complex<double>>(), m.across.cast<std::complex<double>>(),
          m.turned.cast<std::complex<double>>()};
}

DrivenChain chain_of(FilamentDrive drive, const Mobility& m, double sperm_number) {
  const double length = static_cast<double>(m.across.size() - 1), omega = 1e-3;
  const double bending = towed_drags(m).across * omega * std::pow(length / sperm_number, 4);
  return {drive, m, without_delay(m), omega, bending, 0.0};
}

/// Y of a chain, with the drags that it has when it is towed.
double scaled_thrust(FilamentDrive drive, Eigen::Index count, double sperm_number) {
  const Mobility m = spheres(count, 0.92);
  const RodDrag drag = towed_drags(m);
  const DrivenChain chain = chain_of(drive, m, sperm_number);
  const double bending_length = static_cast<double>(count - 1) / sperm_number;
  return stroke_of(chain).thrust /
         ((drag.across - drag.along) * chain.omega * endless_thrust(drive, bending_length));
}

/// First harmonic, over the force, of velocities of markers on a line along x that are displaced by `aside`
/// along z but for the first, on which a force acts that goes as cos(omega t); against the fluid's mean.
Eigen::MatrixXcd moved_by(const fluid::Spec& spec, const Vec3& force, Eigen::Index markers, double aside,
                          int period) {
  const std::unique_ptr<fluid::Fluid> fluid = fluid::make_fluid(spec);
  coupling::Transfer first(spec.grid, {false, false, false}, coupling::Delta::FourPoint), all = first;
  Positions X(markers, 3), at_nodes, u(markers, 3);
  for (Eigen::Index i = 0; i < markers; ++i) X.row(i) << 6.0 + static_cast<double>(i), 5.0, 6.0 + aside;
  first.locate(Positions(Eigen::RowVector3d(6.0, 5.0, 6.0)));
  all.locate(X);
  Eigen::MatrixXcd wave = Eigen::MatrixXcd::Zero(markers, 3);
  const int settled = 12 * period;
  for (int step = 0; step < settled + period; ++step) {
    const double phase = 2.0 * pi * step / period;
    Positions F(1, 3), spread;
    F.row(0) = std::cos(phase) * force;
    first.spread(F, spread);
    // In the step that starts now the velocity before it stands.
    fluid->velocities(all.nodes(), at_nodes);
    all.interpolate(at_nodes, u);
    const Vec3 mean = fluid->totals().momentum / static_cast<double>(spec.grid.count());
    if (step >= settled)
      wave += std::polar(2.0 / period, -phase) *
              (u.rowwise() - mean.transpose()).matrix().cast<std::complex<double>>();
    fluid->collide_and_stream({first.nodes(), &spread});
  }
  return wave;
}

}  // namespace

TEST_CASE("Thrust of a driven filament has its known values") {
  const double sperm_numbers[] = {1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0};
  const double known[][7] = {{0.00926, 0.14753, 0.67666, 1.17283, 1.01821, 0.96193, 1.00717},
                             {0.24840, 1.53410, 0.76034, 0.94258, 1.10154, 0.99946, 1.00537},
                             {0.06596, 1.59260, 1.17637, 0.98002, 1.07094, 1.02559, 0.99908}};
  for (const auto& drive : filament_drives) {
    const double* values = known[static_cast<int>(drive.value)];
    for (int i = 0; i < 7; ++i)
      CHECK(slender_thrust(drive.value, sperm_numbers[i]) == Approx(values[i]).margin(6e-6));
  }
}

TEST_CASE("Thrust of a driven filament has its known peaks") {
  const double peaks[][2] = {{4.07269, 1.17506}, {1.89042, 1.57003}, {2.15829, 1.65254}};
  for (const auto& drive : filament_drives) {
    const auto [at, height] = peaks[static_cast<int>(drive.value)];
    CHECK(slender_thrust(drive.value, at) == Approx(height).margin(6e-6));
    CHECK(slender_thrust(drive.value, 0.99 * at) < slender_thrust(drive.value, at));
    CHECK(slender_thrust(drive.value, 1.01 * at) < slender_thrust(drive.value, at));
  }
}

TEST_CASE("A stiff filament pushes by the little that its drag bends it") {
  // Of first order in Sp^4: w = w0 - i Sp^4 phi with phi'''' = w0, w0 the motion of a rigid rod.
  for (const double sp : {0.1, 0.3}) {
    const double fourth = std::pow(sp, 4);
    CHECK(slender_thrust(FilamentDrive::Hinged, sp) ==
          Approx(11.0 * sqrt2 / 1680.0 * fourth).epsilon(fourth));
    CHECK(slender_thrust(FilamentDrive::Clamped, sp) == Approx(0.25 * fourth).epsilon(fourth));
    CHECK(slender_thrust(FilamentDrive::Angle, sp) ==
          Approx(7.0 / (180.0 * (2.0 - sqrt2)) * fourth * sp * sp).epsilon(fourth));
  }
}

TEST_CASE("A long filament pushes as an endless one") {
  for (const auto& drive : filament_drives) {
    for (const double sp : {20.0, 100.0, 1000.0})
      CHECK(slender_thrust(drive.value, sp) == Approx(1.0).margin(1e-5));
  }
}

TEST_CASE("A rigid chain of markers does not push") {
  for (const auto& drive : filament_drives) {
    DrivenChain chain = chain_of(drive.value, spheres(17, 0.92), 3.0);
    const double soft = stroke_of(chain).thrust;
    chain.angle_stiffness *= 1e6;
    CHECK(std::abs(stroke_of(chain).thrust) < 1e-4 * soft);
  }
}

TEST_CASE("Chains of markers push as a slender filament to 1 over the logarithm of their length") {
  for (const auto& drive : filament_drives) {
    const double sp = drive.value == FilamentDrive::Hinged ? 4.0 : 2.0;
    const double law = slender_thrust(drive.value, sp);
    double before = INFINITY;
    for (const Eigen::Index count : {33, 65, 129, 257}) {
      const double off = std::abs(scaled_thrust(drive.value, count, sp) / law - 1.0);
      CHECK(off < 1.0 / std::log(static_cast<double>(count)));
      CHECK(off < before);
      before = off;
    }
    CHECK(before < 0.13);
  }
}

TEST_CASE("Markers on a line move each other under a force that oscillates as the lattice's waves say") {
  constexpr double force = 1e-7, aside = 0.001;  // the kernel's second derivative jumps at a node
  constexpr Eigen::Index markers = 5;
  constexpr int period = 60;
  const fluid::Spec spec{.grid = {{16, 10, 12}}, .relaxation_time = 0.8};
  const OscillatingMobility exact = oscillating_line_mobility(spec.grid, 0.8, markers, 2.0 * pi / period);
  const auto of = [&](const Vec3& f, double z) { return moved_by(spec, force * f, markers, z, period); };
  const Eigen::MatrixXcd along = of(Vec3::UnitX(), 0.0) / force, across = of(Vec3::UnitZ(), 0.0) / force;
  const Eigen::MatrixXcd turned = of(Vec3::UnitZ(), aside) / (force * aside);
  for (Eigen::Index d = 0; d < markers; ++d) {
    CHECK(std::abs(along(d, 0) - exact.along[d]) < 1e-4 * std::abs(exact.along[0]));
    CHECK(std::abs(across(d, 2) - exact.across[d]) < 1e-4 * std::abs(exact.across[0]));
    CHECK(std::abs(turned(d, 0) - exact.turned[d]) < 1e-3 * std::abs(exact.turned[1]));
  }
  CHECK(std::abs(exact.across[4].imag()) > 0.01 * std::abs(exact.across[0]));
}
