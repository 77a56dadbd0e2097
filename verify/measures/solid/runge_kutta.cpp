#include "measures/solid/runge_kutta.hpp"

#include <fmt/format.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>

#include <vector>

#include "base/error.hpp"
#include "base/root.hpp"
#include "base/stop.hpp"
#include "measures/solid/held.hpp"

namespace veriflex::measures {

namespace {

using State = std::vector<double>;  // displacement, then velocity, as Positions lie in memory

}  // namespace

struct RungeKutta::Data {
  solid::Material material;
  const solid::Network& network;
  double mass, drag;
  solid::Workspace work{};
  Positions gradient{};
  gsl_odeiv2_system system{};
  Held<gsl_odeiv2_step, gsl_odeiv2_step_free> method{};
  Held<gsl_odeiv2_control, gsl_odeiv2_control_free> control{};
  Held<gsl_odeiv2_evolve, gsl_odeiv2_evolve_free> evolve{};
  State now{}, before{};
  std::int64_t drag_evaluations = 0;
  double time = 0.0, time_before = 0.0, next_step = 0.0;
  solid::NetworkParts network_parts{};
  parts::Built part{};

  // d(u, v)/dt. A state in which a bond has no force is refused, and GSL halves the step.
  int rate(const double* y, double* dydt) {
    const Eigen::Index nodes = network.node_count();
    const auto coordinates = static_cast<std::ptrdiff_t>(3 * nodes);
    const Positions u = Eigen::Map<const Positions>(y, nodes, 3);
    const bool is_defined = solid::visit(material, [&](const auto& law, const auto& angle) {
      return solid::deform(law, network, u, work) && solid::gradient(law, angle, network, work, gradient);
    });
    if (!is_defined) return GSL_FAILURE;
    std::copy(y + coordinates, y + 2 * coordinates, dydt);
    ++drag_evaluations;
    Eigen::Map<Positions>(dydt + coordinates, nodes, 3) =
        -(gradient + drag * Eigen::Map<const Positions>(y + coordinates, nodes, 3)) / mass;
    return GSL_SUCCESS;
  }

  Positions part_of(const State& state, Eigen::Index which) const {
    const Eigen::Index nodes = network.node_count();
    return Eigen::Map<const Positions>(state.data() + which * 3 * nodes, nodes, 3);
  }
};

RungeKutta::RungeKutta(const solid::Material& material, const solid::Network& network, double node_mass,
                       double drag, double tolerance, double frequency, const Positions& u,
                       const Positions& v)
    : data_(std::make_unique<Data>(
          Data{.material = material, .network = network, .mass = node_mass, .drag = drag})) {
  Data& d = *data_;
  d.now.assign(u.data(), u.data() + u.size());
  d.now.insert(d.now.end(), v.data(), v.data() + v.size());
  d.system = {[](double, const double* y, double* dydt, void* data) {
                return static_cast<Data*>(data)->rate(y, dydt);
              },
              nullptr, d.now.size(), &d};
  std::vector<double> scale(d.now.size(), u.cwiseAbs().maxCoeff());
  for (std::size_t i = scale.size() / 2; i < scale.size(); ++i) scale[i] *= frequency;
  d.method.reset(gsl_odeiv2_step_alloc(gsl_odeiv2_step_rk8pd, d.now.size()));
  d.control.reset(gsl_odeiv2_control_scaled_new(tolerance, 0.0, 1.0, 0.0, scale.data(), scale.size()));
  d.evolve.reset(gsl_odeiv2_evolve_alloc(d.now.size()));
  if (!d.method || !d.control || !d.evolve) throw std::bad_alloc();
  d.next_step = 1e-3 / frequency;
  d.network_parts = solid::parts_of(network);
  // This state and the one before, and half of one for the gradient; of GSL 15 for the method, 4 for its
  // steps, 1 of scales.
  constexpr double states = 22.5;
  d.part = {parts::Kind::RungeKutta, states * parts::array_bytes(d.now)};
}

RungeKutta::~RungeKutta() = default;
RungeKutta::RungeKutta(RungeKutta&&) noexcept = default;

void RungeKutta::step() {
  Data& d = *data_;
  stop_if_asked("step", steps() + 1);
  d.before = d.now;
  d.time_before = d.time;
  const int status = gsl_odeiv2_evolve_apply(d.evolve.get(), d.control.get(), d.method.get(), &d.system,
                                             &d.time, INFINITY, &d.next_step, d.now.data());
  if (status == GSL_SUCCESS) return;
  throw NumericalFailure(fmt::format("step {}: no step, however small, keeps the tolerance ({})", steps() + 1,
                                     gsl_strerror(status)),
                         FailureMode::TimeStep);
}

double RungeKutta::passage(const Eigen::VectorXd& weights) const {
  Data& d = *data_;
  State error(d.now.size());
  const auto amount_after = [&](double duration) {
    State state = d.before;
    gsl_odeiv2_step_reset(d.method.get());
    if (duration > 0.0 && gsl_odeiv2_step_apply(d.method.get(), d.time_before, duration, state.data(),
                                                error.data(), nullptr, nullptr, &d.system) != GSL_SUCCESS) {
      throw NumericalFailure("a part of a step that was made cannot be", FailureMode::TimeStep);
    }
    return weights.dot(d.part_of(state, 0).col(2));
  };
  return d.time_before + bracketed_root(amount_after, 0.0, d.time - d.time_before);
}

Positions RungeKutta::displacement() const { return data_->part_of(data_->now, 0); }
Positions RungeKutta::velocity() const { return data_->part_of(data_->now, 1); }
double RungeKutta::time() const { return data_->time; }
std::int64_t RungeKutta::steps() const { return static_cast<std::int64_t>(data_->evolve->count); }
std::int64_t RungeKutta::drag_evaluations() const { return data_->drag_evaluations; }

}  // namespace veriflex::measures
