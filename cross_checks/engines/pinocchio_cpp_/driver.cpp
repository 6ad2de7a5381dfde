// Pinocchio's forward dynamics under Runge-Kutta methods, as one writes them over its headers in C++.
//
// The state is y = (q, v). A quaternion in q is integrated as four numbers and normalised before it is used, so that
// the methods keep their order on ball joints (pinocchio::integrate in a Runge-Kutta stage has order 2 there).

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <vector>

#include <pinocchio/multibody.hpp>
#include <pinocchio/algorithm/aba.hpp>
#ifdef EVERY_ALGORITHM
#include <pinocchio/algorithm/constrained-dynamics.hpp>
#include <pinocchio/algorithm/loop-constrained-aba.hpp>
#endif

namespace {

using Vector = Eigen::VectorXd;
using Read = Eigen::Ref<const Vector>;  // the arguments that the library has compiled its algorithms for
using Eigen::Map;
using Eigen::Vector3d;

enum Kind { TURN_Z, TURN, SLIDE, BALL, TRANSLATION, FREE };
enum Form { ABA_LOCAL, ABA_WORLD, CONSTRAINED, LOOP_ABA };  // which algorithm gives the accelerations
enum Outcome { SUCCESS, STEP_TOO_SMALL, TOO_MANY_STEPS };

struct Turn { int q, v, flight; };  // a quaternion, its rate, and where its free-flyer's position is (-1: a ball joint)

struct Tree {
  pinocchio::Model model;
  pinocchio::Data data;
  std::vector<Turn> turns;
  std::vector<std::pair<int, int>> plain;  // coordinates whose rate is a velocity
  Vector tau, q, v;
  Form form;
#ifdef EVERY_ALGORITHM
  std::vector<pinocchio::RigidConstraintModel, Eigen::aligned_allocator<pinocchio::RigidConstraintModel>> contacts;
  std::vector<pinocchio::RigidConstraintData, Eigen::aligned_allocator<pinocchio::RigidConstraintData>> contact_data;
  pinocchio::ProximalSettings proximal;
#endif
};

const Vector& accelerations(Tree& tree) {
  using pinocchio::Convention;
#ifdef EVERY_ALGORITHM
  if (tree.form == ABA_WORLD) {
    return pinocchio::aba(tree.model, tree.data, tree.q, tree.v, tree.tau, Convention::WORLD);
  }
  if (tree.form == CONSTRAINED) {
    return pinocchio::constraintDynamics(tree.model, tree.data, tree.q, tree.v, tree.tau, tree.contacts,
                                         tree.contact_data, tree.proximal);
  }
  if (tree.form == LOOP_ABA) {
    return pinocchio::lcaba(tree.model, tree.data, tree.q, tree.v, tree.tau, tree.contacts, tree.contact_data,
                            tree.proximal);
  }
#endif
  return pinocchio::aba(tree.model, tree.data, Read(tree.q), Read(tree.v), Read(tree.tau), Convention::LOCAL);
}

pinocchio::JointModel joint_model(int kind, const Vector3d& axis) {
  switch (kind) {
    case TURN_Z: return pinocchio::JointModelRZ();
    case TURN: return pinocchio::JointModelRevoluteUnaligned(axis);
    case SLIDE: return pinocchio::JointModelPrismaticUnaligned(axis);
    case BALL: return pinocchio::JointModelSpherical();
    case TRANSLATION: return pinocchio::JointModelTranslation();
    default: return pinocchio::JointModelFreeFlyer();
  }
}

void number_coordinates(Tree& tree, int joint, int kind) {
  const int q = tree.model.joints[joint].idx_q(), v = tree.model.joints[joint].idx_v();
  if (kind == FREE) tree.turns.push_back({q + 3, v + 3, q});
  else if (kind == BALL) tree.turns.push_back({q, v, -1});
  else for (int k = 0; k < tree.model.joints[joint].nq(); ++k) tree.plain.emplace_back(q + k, v + k);
}

// The rate of y: quaternions turn with v in the body's axes, and so do free-flyers' velocities.
void rate(Tree& tree, const Vector& y, Vector& dy) {
  const int nq = tree.model.nq, nv = tree.model.nv;
  tree.q = y.head(nq);
  tree.v = y.tail(nv);
  const Vector& v = tree.v;
  for (const auto& [to, from] : tree.plain) dy[to] = v[from];
  for (const Turn& turn : tree.turns) {
    auto theta = tree.q.segment<4>(turn.q);  // x, y, z, w
    theta.normalize();
    const Vector3d e = theta.head<3>(), omega = v.segment<3>(turn.v);
    dy.segment<3>(turn.q) = 0.5 * (theta[3] * omega + e.cross(omega));
    dy[turn.q + 3] = -0.5 * e.dot(omega);
    if (turn.flight < 0) continue;
    const Vector3d speed = v.segment<3>(turn.v - 3), twice = 2.0 * e.cross(speed);
    dy.segment<3>(turn.flight) = speed + theta[3] * twice + e.cross(twice);
  }
  dy.tail(nv) = accelerations(tree);
}

struct Tableau { const double *a, *b, *e3, *e5; };  // (12, 12), (12,), (13,), (13,): stages and error estimates
constexpr int STAGES = 12;

// DOP853 with the step control of SciPy's (scipy/integrate/_ivp/rk.py, base.py, common.py), after
// Hairer, Norsett, Wanner: Solving Ordinary Differential Equations I, II.4 and II.10.
struct Dop853 {
  Tree& tree;
  const Tableau tableau;
  const double rtol, atol;
  double t, h = 0.0;
  Vector y, trial, scale, stage;
  std::vector<Vector> k;
  long calls = 0, rejected = 0;

  Dop853(Tree& tree, const Tableau& tableau, double rtol, double atol, const Vector& start)
      : tree(tree), tableau(tableau), rtol(rtol), atol(atol), t(0.0), y(start), trial(start), scale(start),
        stage(start), k(STAGES + 1, start) { call(y, k[0]); }

  void call(const Vector& at, Vector& into) { rate(tree, at, into); ++calls; }

  double norm(const Vector& x) const { return std::sqrt((x.array() / scale.array()).square().mean()); }

  // Hairer, Norsett, Wanner I, II.4: the first step, for an error estimate of order 7.
  void choose_first_step(double until) {
    scale = atol + y.array().abs() * rtol;
    const double d0 = norm(y), d1 = norm(k[0]), interval = until - t;
    double h0 = d0 < 1e-5 || d1 < 1e-5 ? 1e-6 : 0.01 * d0 / d1;
    h0 = std::min(h0, interval);
    stage = y + h0 * k[0];
    call(stage, k[1]);
    stage = k[1] - k[0];
    const double d2 = norm(stage) / h0;
    const double h1 = d1 <= 1e-15 && d2 <= 1e-15 ? std::max(1e-6, h0 * 1e-3)
                                                 : std::pow(0.01 / std::max(d1, d2), 1.0 / 8.0);
    h = std::min({100.0 * h0, h1, interval});
  }

  // sum of weights[j] k[j], into stage
  void combine(const double* weights, int count) {
    stage.setZero();
    for (int j = 0; j < count; ++j)
      if (weights[j] != 0.0) stage += weights[j] * k[j];
  }

  double error_of(double step) {
    scale = atol + y.array().abs().max(trial.array().abs()) * rtol;
    combine(tableau.e5, STAGES + 1);
    const double five = (stage.array() / scale.array()).square().sum();
    combine(tableau.e3, STAGES + 1);
    const double three = (stage.array() / scale.array()).square().sum();
    if (five == 0.0 && three == 0.0) return 0.0;
    return std::abs(step) * five / std::sqrt((five + 0.01 * three) * static_cast<double>(y.size()));
  }

  void attempt(double step) {
    for (int s = 1; s < STAGES; ++s) {
      combine(tableau.a + s * STAGES, s);
      trial = y + step * stage;
      call(trial, k[s]);
    }
    combine(tableau.b, STAGES);
    trial = y + step * stage;
    call(trial, k[STAGES]);
  }

  // One accepted step towards `landing`, which it does not pass. False: the step has become too small.
  bool step(double landing) {
    const double smallest = 10.0 * (std::nextafter(t, std::numeric_limits<double>::infinity()) - t);
    const double planned = h;
    double size = std::max(h, smallest);
    for (bool before = false;; before = true) {
      if (!(size >= smallest)) return false;
      const double next = std::min(t + size, landing), taken = next - t;
      attempt(taken);
      const double error = error_of(taken);
      if (error < 1.0) {
        double factor = error == 0.0 ? 10.0 : std::min(10.0, 0.9 * std::pow(error, -1.0 / 8.0));
        if (before) factor = std::min(1.0, factor);
        h = taken * factor;
        // a step cut short at a landing leaves the next one's size as it was
        if (next == landing && taken < planned) h = std::max(planned, h);
        t = next;
        y.swap(trial);
        k[0].swap(k[STAGES]);
        return true;
      }
      ++rejected;
      size = taken * std::max(0.2, 0.9 * std::pow(error, -1.0 / 8.0));
    }
  }
};

struct Report { double seconds; long steps, calls, rejected; int reached, outcome; double t; };

double since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

using Square = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

pinocchio::SE3 placed(const double* x) { return {Map<const Square>(x), Map<const Vector3d>(x + 9)}; }

#define EXPORTED extern "C" __attribute__((visibility("default")))

// joints: for each a kind, its parent, and 28 numbers: placement (rotation by rows, translation), axis,
// mass, centre of mass, and inertia about it (by rows of three). gravity: (3,) m/s^2.
EXPORTED Tree* make_tree(int form, int n, const int* kinds, const int* parents, const double* numbers,
                         const double* gravity) {
  auto* tree = new Tree;
  tree->form = static_cast<Form>(form);
  for (int k = 0; k < n; ++k) {
    const double* x = numbers + 28 * k;
    const int joint = tree->model.addJoint(parents[k], joint_model(kinds[k], Map<const Vector3d>(x + 12)), placed(x),
                                           "joint " + std::to_string(k));
    tree->model.inertias[joint] = pinocchio::Inertia(
        x[15], Map<const Vector3d>(x + 16), pinocchio::Symmetric3(Eigen::Matrix3d(Map<const Square>(x + 19))));
    number_coordinates(*tree, joint, kinds[k]);
  }
  tree->model.gravity.linear() = Map<const Vector3d>(gravity);
  tree->data = pinocchio::Data(tree->model);
  tree->tau = tree->v = Vector::Zero(tree->model.nv);
  tree->q = Vector::Zero(tree->model.nq);
  return tree;
}

#ifdef EVERY_ALGORITHM
// joints: two for each contact of 3 or 6 rows; numbers: its placements in them (24); gains and settings: (5,).
EXPORTED void close_loops(Tree* tree, int n, const int* rows, const int* joints, const double* numbers,
                          const double* settings) {
  for (int k = 0; k < n; ++k) {
    const auto type = rows[k] == 6 ? pinocchio::CONTACT_6D : pinocchio::CONTACT_3D;
    const double* x = numbers + 24 * k;
    pinocchio::RigidConstraintModel contact(type, tree->model, joints[2 * k], placed(x), joints[2 * k + 1],
                                            placed(x + 12), pinocchio::LOCAL);
    contact.setBaumgarteCorrectorParameters(
        pinocchio::BaumgarteCorrectorParametersTpl<double>(settings[0], settings[1]), pinocchio::MaximalSelection());
    tree->contacts.push_back(contact);
    tree->contact_data.push_back(contact.createData());
  }
  tree->proximal = pinocchio::ProximalSettings(settings[2], settings[3], static_cast<int>(settings[4]));
  if (tree->form == LOOP_ABA) pinocchio::computeJointMinimalOrdering(tree->model, tree->data, tree->contacts);
  else pinocchio::initConstraintDynamics(tree->model, tree->data, tree->contacts, tree->contact_data);
}
#endif

EXPORTED void free_tree(Tree* tree) { delete tree; }

EXPORTED void derivative(Tree* tree, const double* y, double* dy) {
  const int n = tree->model.nq + tree->model.nv;
  Vector out(n);
  rate(*tree, Map<const Vector>(y, n), out);
  Map<Vector>(dy, n) = out;
}

// states: (n_t, n), of which the first row is the start; counts: steps between the output times.
EXPORTED Report run_rk4(Tree* tree, double* states, int n_t, const int* counts, double h) {
  const auto start = std::chrono::steady_clock::now();
  const int n = tree->model.nq + tree->model.nv;
  Vector y = Map<const Vector>(states, n), k(n), total(n), at(n);
  Report report{};
  for (report.reached = 1; report.reached < n_t; ++report.reached) {
    for (int step = 0; step < counts[report.reached - 1]; ++step, ++report.steps) {
      rate(*tree, y, k);
      total = y + h / 6.0 * k;
      for (const double ahead : {0.5, 0.5, 1.0}) {
        at = y + ahead * h * k;
        rate(*tree, at, k);
        total += (ahead == 1.0 ? h / 6.0 : h / 3.0) * k;
      }
      y.swap(total);
    }
    Map<Vector>(states + static_cast<long>(report.reached) * n, n) = y;
    if (!y.allFinite()) { ++report.reached; break; }
  }
  report.calls = 4 * report.steps;
  report.seconds = since(start);
  return report;
}

// The same with DOP853, which lands on every output time: nothing is interpolated.
EXPORTED Report run_dop853(Tree* tree, double* states, int n_t, const double* times, double rtol, double atol,
                           long max_steps, const double* a, const double* b, const double* e3, const double* e5) {
  const auto start = std::chrono::steady_clock::now();
  const int n = tree->model.nq + tree->model.nv;
  Report report{};
  Dop853 solver(*tree, {a, b, e3, e5}, rtol, atol, Map<const Vector>(states, n));
  solver.choose_first_step(times[n_t - 1]);
  for (report.reached = 1; report.reached < n_t && report.outcome == SUCCESS; ) {
    const double landing = times[report.reached];
    while (solver.t < landing && report.outcome == SUCCESS) {
      if (report.steps >= max_steps) report.outcome = TOO_MANY_STEPS;
      else if (solver.step(landing)) ++report.steps;
      else report.outcome = STEP_TOO_SMALL;
    }
    if (report.outcome == SUCCESS) Map<Vector>(states + static_cast<long>(report.reached++) * n, n) = solver.y;
  }
  report.calls = solver.calls;
  report.rejected = solver.rejected;
  report.t = solver.t;
  report.seconds = since(start);
  return report;
}
