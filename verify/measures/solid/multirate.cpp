#include "measures/solid/multirate.hpp"

#include <arkode/arkode_arkstep.h>
#include <arkode/arkode_mristep.h>
#include <fmt/format.h>
#include <nvector/nvector_serial.h>

#include <array>
#include <type_traits>

#include "base/error.hpp"
#include "base/mutant.hpp"
#include "base/root.hpp"
#include "base/stop.hpp"
#include "measures/solid/held.hpp"
#include "solid/inadmissible.hpp"

namespace veriflex::measures {

namespace {

static_assert(std::is_same_v<realtype, double>);

using Context = Held<std::remove_pointer_t<SUNContext>, SUNContext_Free>;
using Vector = Held<std::remove_pointer_t<N_Vector>, N_VDestroy>;
using Stepper = Held<std::remove_pointer_t<MRIStepInnerStepper>, MRIStepInnerStepper_Free>;
using Table = Held<std::remove_pointer_t<ARKodeButcherTable>, ARKodeButcherTable_Free>;
using Coupling = Held<std::remove_pointer_t<MRIStepCoupling>, MRIStepCoupling_Free>;

// What the library refuses though all it was given is sound.
void expect(int status, const char* what) {
  if (status < 0) throw std::runtime_error(fmt::format("SUNDIALS refuses {} ({})", what, status));
}

template <class T>
T* made(T* thing) {
  if (thing == nullptr) throw std::bad_alloc();
  return thing;
}

Table method_of_substeps(int order) {
  if (order == 3) return Table(made(ARKodeButcherTable_LoadERK(ARKODE_KNOTH_WOLKE_3_3)));
  std::array c{0.0, 0.5, 0.5, 1.0};
  std::array a{0.0, 0.0, 0.0, 0.0,  //
               0.5, 0.0, 0.0, 0.0,  //
               0.0, 0.5, 0.0, 0.0,  //
               0.0, 0.0, 1.0, 0.0};
  std::array b{1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
  return Table(made(ARKodeButcherTable_Create(4, 4, 0, c.data(), a.data(), b.data(), nullptr)));
}

}  // namespace

struct Multirate::Data {
  solid::Material material;
  const solid::Network& network;
  double mass, drag, dt;
  solid::Workspace work{};
  Positions gradient{};
  std::int64_t steps = 0, drag_evaluations = 0;
  double time = 0.0, time_before = 0.0;
  Positions outside{};  // the last displacement in which a bond has no force
  Context context{};
  Vector now{}, before{};
  Held<void, ARKStepFree> fast{};
  Stepper stepper{};
  Held<void, MRIStepFree> method{};
  solid::NetworkParts network_parts{};
  parts::Built part{};

  Positions part_of(const Vector& state, Eigen::Index which) const {
    return part_of(N_VGetArrayPointer(state.get()), which);
  }
  // A state is displacement, then velocity, as Positions lie in memory.
  Positions part_of(const double* state, Eigen::Index which) const {
    const Eigen::Index nodes = network.node_count();
    return Eigen::Map<const Positions>(state + which * 3 * nodes, nodes, 3);
  }

  bool evaluate(const Positions& u) {
    return solid::visit(material, [&](const auto& law, const auto& angle) {
      return solid::deform(law, network, u, work) && solid::gradient(law, angle, network, work, gradient);
    });
  }

  // The bonds' part of d(u, v)/dt, with the motion itself.
  int fast_rate(const double* y, double* dydt) {
    const Positions u = part_of(y, 0);
    if (!evaluate(u)) {
      outside = u;
      return -1;
    }
    const Eigen::Index coordinates = u.size();
    std::copy(y + coordinates, y + 2 * coordinates, dydt);
    Eigen::Map<Positions>(dydt + coordinates, u.rows(), 3) = -gradient / mass;
    return 0;
  }

  // The drag's part.
  int slow_rate(const double* y, double* dydt) {
    ++drag_evaluations;
    const Eigen::Index coordinates = 3 * network.node_count();
    std::fill(dydt, dydt + coordinates, 0.0);
    for (Eigen::Index i = coordinates; i < 2 * coordinates; ++i) dydt[i] = -drag / mass * y[i];
    return 0;
  }

  // Of the sum of weights . u_z.
  double acceleration(const Eigen::VectorXd& weights, const Vector& state) {
    evaluate(part_of(state, 0));
    const Positions v = part_of(state, 1);
    return -weights.dot(gradient.col(2) + drag * v.col(2)) / mass;
  }
};

Multirate::Multirate(const solid::Material& material, const solid::Network& network, double node_mass,
                     double drag, int order, double dt, int substeps, const Positions& u, const Positions& v)
    : data_(std::make_unique<Data>(
          Data{.material = material, .network = network, .mass = node_mass, .drag = drag, .dt = dt})) {
  Data& d = *data_;
  SUNContext context = nullptr;
  expect(SUNContext_Create(nullptr, &context), "a context");
  d.context.reset(context);
  d.now.reset(made(N_VNew_Serial(2 * u.size(), context)));
  // Sums of several states in one pass, up to a seventh less of the time.
  expect(N_VEnableFusedOps_Serial(d.now.get(), SUNTRUE), "fused operations");
  std::copy(u.data(), u.data() + u.size(), N_VGetArrayPointer(d.now.get()));
  std::copy(v.data(), v.data() + v.size(), N_VGetArrayPointer(d.now.get()) + u.size());
  d.before.reset(made(N_VClone(d.now.get())));

  const ARKRhsFn fast = [](realtype, N_Vector y, N_Vector dydt, void* data) {
    return static_cast<Data*>(data)->fast_rate(N_VGetArrayPointer(y), N_VGetArrayPointer(dydt));
  };
  const ARKRhsFn slow = [](realtype, N_Vector y, N_Vector dydt, void* data) {
    return static_cast<Data*>(data)->slow_rate(N_VGetArrayPointer(y), N_VGetArrayPointer(dydt));
  };
  const Table table = method_of_substeps(order);
  d.fast.reset(made(ARKStepCreate(fast, nullptr, 0.0, d.now.get(), context)));
  expect(ARKStepSetUserData(d.fast.get(), &d), "data");
  expect(ARKStepSetErrFile(d.fast.get(), nullptr), "silence");
  expect(ARKStepSetTables(d.fast.get(), order, 0, nullptr, table.get()), "a method of the sub-steps");
  expect(ARKStepSetFixedStep(d.fast.get(), dt / substeps), "sub-steps");
  expect(ARKStepSetMaxNumSteps(d.fast.get(), -1), "sub-steps without limit");
  // Hermite's interpolation, which nobody asks for, would cost an evaluation a sub-step.
  expect(ARKStepSetInterpolantType(d.fast.get(), ARK_INTERP_LAGRANGE), "an interpolation");

  MRIStepInnerStepper stepper = nullptr;
  expect(ARKStepCreateMRIStepInnerStepper(d.fast.get(), &stepper), "sub-steps of a step");
  d.stepper.reset(stepper);
  const Coupling coupling(made(MRIStepCoupling_LoadTable(
      order == 3 || planted(Mutant::multirate_order_ignored) ? ARKODE_MIS_KW3 : ARKODE_MRI_GARK_ERK45a)));
  d.method.reset(made(MRIStepCreate(slow, nullptr, 0.0, d.now.get(), stepper, context)));
  expect(MRIStepSetUserData(d.method.get(), &d), "data");
  expect(MRIStepSetErrFile(d.method.get(), nullptr), "silence");
  expect(MRIStepSetCoupling(d.method.get(), coupling.get()), "a method of the steps");
  expect(MRIStepSetFixedStep(d.method.get(), dt), "steps");
  expect(MRIStepSetInterpolantType(d.method.get(), ARK_INTERP_LAGRANGE), "an interpolation");

  d.network_parts = solid::parts_of(network);
  long reals[2] = {}, integers[2] = {};
  expect(ARKStepGetWorkSpace(d.fast.get(), &reals[0], &integers[0]), "its memory");
  expect(MRIStepGetWorkSpace(d.method.get(), &reals[1], &integers[1]), "its memory");
  // This state and the one before, half a state for the gradient, and what the library states.
  d.part = {parts::Kind::RungeKutta, sizeof(double) * (2.5 * static_cast<double>(2 * u.size()) +
                                                       static_cast<double>(reals[0] + reals[1]))};
}

Multirate::~Multirate() = default;
Multirate::Multirate(Multirate&&) noexcept = default;

void Multirate::step() {
  Data& d = *data_;
  stop_if_asked("step", d.steps + 1);
  N_VScale(1.0, d.now.get(), d.before.get());
  d.time_before = d.time;
  const int status = MRIStepEvolve(d.method.get(), d.time + d.dt, d.now.get(), &d.time, ARK_ONE_STEP);
  if (status >= 0) {
    ++d.steps;
    return;
  }
  if (d.outside.size() > 0) {
    throw NumericalFailure(fmt::format("step {}: {}", d.steps + 1,
                                       solid::what_is_inadmissible(d.material, d.network, d.outside)),
                           FailureMode::Bond);
  }
  throw NumericalFailure(
      fmt::format("step {}: SUNDIALS cannot make it ({})", d.steps + 1, MRIStepGetReturnFlagName(status)),
      FailureMode::TimeStep);
}

double Multirate::passage(const Eigen::VectorXd& weights) const {
  Data& d = *data_;
  const double h = d.time - d.time_before;
  const double x = weights.dot(d.part_of(d.before, 0).col(2)), xe = weights.dot(d.part_of(d.now, 0).col(2));
  const double v = h * weights.dot(d.part_of(d.before, 1).col(2)),
               ve = h * weights.dot(d.part_of(d.now, 1).col(2));
  const double a = h * h * d.acceleration(weights, d.before), ae = h * h * d.acceleration(weights, d.now);
  const double way = xe - x - v - 0.5 * a, rise = ve - v - a, bend = ae - a;
  const double c3 = 10.0 * way - 4.0 * rise + 0.5 * bend, c4 = -15.0 * way + 7.0 * rise - bend,
               c5 = 6.0 * way - 3.0 * rise + 0.5 * bend;
  const auto amount = [&](double s) {
    return s == 1.0 ? xe : x + s * (v + s * (0.5 * a + s * (c3 + s * (c4 + s * c5))));
  };
  return d.time_before + h * bracketed_root(amount, 0.0, 1.0);
}

Positions Multirate::displacement() const { return data_->part_of(data_->now, 0); }
Positions Multirate::velocity() const { return data_->part_of(data_->now, 1); }
double Multirate::time() const { return data_->time; }
std::int64_t Multirate::steps() const { return data_->steps; }
std::int64_t Multirate::drag_evaluations() const { return data_->drag_evaluations; }

}  // namespace veriflex::measures
