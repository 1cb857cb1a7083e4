// Problems of C3, those of c3rt solve, and what they come to.
#include "python/src/problem.hpp"

#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/vector.h>
#include <nlohmann/json.hpp>

#include "cli/matrix_json.hpp"
#include "cli/monolithic.hpp"
#include "controller/c3/solver.hpp"
#include "controller/rt/worker_pool.hpp"
#include "python/src/arrays.hpp"
#include "python/src/bind.hpp"

namespace c3rt::python {
namespace {

using config::ProblemFile;
using lcs::Lcs;
using Json = nlohmann::json;
using namespace nb::literals;

using Shared = std::shared_ptr<const ProblemFile>;

// ---- arguments as a problem file, which has one reader

bool ends_with(const std::string& key, const std::string& end) {
  return key.size() >= end.size() && key.compare(key.size() - end.size(), end.size(), end) == 0;
}

/// A number that JSON does not have becomes text, which the reader refuses by its key; but where
/// it is a bound that does not bind, none.
Json number(double value, const std::string& key) {
  if (std::isfinite(value)) return value;
  const bool free = (value < 0 && ends_with(key, "min")) || (value > 0 && ends_with(key, "max"));
  if (free) return nullptr;
  return std::to_string(value);
}

/// @param axis of the numbers, the outermost first  @param next the number to come
Json nested(const Numbers& of, std::size_t axis, std::size_t& next, const std::string& key) {
  if (axis == of.shape.size()) return number(of.values[next++], key);
  Json list = Json::array();
  for (std::size_t i = 0; i < of.shape[axis]; ++i) list.push_back(nested(of, axis + 1, next, key));
  return list;
}

Json to_json(const Eigen::MatrixXd& of) { return cli::rows_of<Json>(of); }

Json to_json(const Eigen::VectorXd& of) {
  Json list = Json::array();
  for (Eigen::Index i = 0; i < of.size(); ++i) list.push_back(of[i]);
  return list;
}

Json to_json(const Lcs& of) {
  return {{"A", to_json(of.A)}, {"B", to_json(of.B)}, {"D", to_json(of.D)}, {"d", to_json(of.d)},
          {"E", to_json(of.E)}, {"F", to_json(of.F)}, {"H", to_json(of.H)}, {"c", to_json(of.c)}};
}

Json to_json(nb::handle of, const std::string& key) {
  if (of.is_none()) return nullptr;
  if (nb::isinstance<Lcs>(of)) return to_json(nb::cast<const Lcs&>(of));
  if (nb::isinstance<nb::bool_>(of)) return nb::cast<bool>(of);
  if (nb::isinstance<nb::str>(of)) return nb::cast<std::string>(of);
  if (nb::isinstance<nb::int_>(of)) {
    std::int64_t value = 0;
    return nb::try_cast(of, value) ? Json(value) : Json("a number beyond 64 bits");
  }
  if (nb::isinstance<nb::float_>(of)) return number(nb::cast<double>(of), key);
  if (nb::isinstance<nb::list>(of) || nb::isinstance<nb::tuple>(of)) {
    Json list = Json::array();
    for (const nb::handle entry : of) list.push_back(to_json(entry, key));
    return list;
  }
  const Numbers values = numbers(of, key);
  std::size_t next = 0;
  return nested(values, 0, next, key);
}

const char* const kTopKeys[] = {"projection", "method",  "qp",  "trace",
                                "deadline_s", "threads", "seed"};

Problem make_problem(nb::handle lcs, nb::handle x0, const nb::kwargs& keys) {
  Json json{{"schema", "c3-problem-1"},
            {"lcs", to_json(lcs, "lcs")},
            {"x0", to_json(x0, "x0")},
            {"params", Json::object()}};
  for (const auto [key, value] : keys) {
    const auto name = nb::cast<std::string>(key);
    bool top = false;
    for (const char* of : kTopKeys) top = top || name == of;
    (top ? json : json["params"])[name] = to_json(value, name);
  }
  return parse_problem(json.dump(), "Problem");
}

// ---- results

/// What a solve came to. The solution is that of Algorithm 1; MIQP15 has none.
struct Result {
  Shared problem;
  config::ProblemResult of;
  std::optional<c3::Solution> solution;
  bool found;
  std::string json() const {
    return config::to_json(*problem, of, solution ? solution->trace : std::vector<c3::Iterate>());
  }
};

const c3::Solution& solution_of(const Result& result) {
  if (!result.solution)
    throw std::invalid_argument("method: expected \"C3\" for copies and duals, got \"MIQP15\"");
  return *result.solution;
}

template <typename T, typename Get>
auto rows(Get get) {
  return [get](nb::handle_t<T> self) { return view_stages(get(nb::cast<const T&>(self)), self); };
}

// ---- solving

/// Lets Ctrl-C end a solve: the GIL is taken for that now and then, by the thread that called.
struct Interrupt {
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds kLookEvery{50};

  Clock::time_point look = Clock::now() + kLookEvery;
  std::optional<Clock::time_point> end = {};
  std::thread::id caller = std::this_thread::get_id();
  bool raised = false;

  static bool reached(void* context) noexcept {
    auto& self = *static_cast<Interrupt*>(context);
    if (std::this_thread::get_id() != self.caller) return false;
    const Clock::time_point now = Clock::now();
    if (now >= self.look && !self.raised) {
      self.look = now + kLookEvery;
      const nb::gil_scoped_acquire gil;
      self.raised = PyErr_CheckSignals() != 0;
    }
    return self.raised || (self.end && now >= *self.end);
  }
};

/// Algorithm 1 for problems of the same sizes, costs and settings. One solve at a time; other
/// threads wait for theirs.
class Solver {
 public:
  explicit Solver(const Problem& problem)
      : problem_(problem.file),
        pool_(problem.file->threads),
        solver_(problem.file->sizes, problem.file->settings,
                problem.file->threads > 1
                    ? c3::Parallel{&rt::WorkerPool::run_on, &pool_, problem.file->threads}
                    : c3::Parallel{}) {
    if (problem_->method != config::Method::kC3)
      throw std::invalid_argument("Solver: expected a problem of method \"C3\", got \"MIQP15\"");
    solver_.set_costs(problem_->costs, problem_->constraints);
  }

  Result solve(nb::handle x0, nb::handle lcs, nb::handle x_desired, const Result* start,
               std::optional<double> deadline_s) {
    const c3::Sizes& sizes = problem_->sizes;
    Shared problem = problem_;
    if (!x0.is_none() || !lcs.is_none() || !x_desired.is_none()) {
      const std::shared_ptr<ProblemFile> changed = spare();
      changed->x0 = x0.is_none() ? problem_->x0 : vector(x0, "x0", sizes.n_x);
      changed->x_desired = x_desired.is_none() ? problem_->x_desired : desired(x_desired);
      changed->lcs = lcs.is_none() ? problem_->lcs : systems(lcs);
      problem = changed;
    }
    if (start != nullptr) require_start(*start);
    Interrupt interrupt;
    if (!deadline_s) deadline_s = problem_->deadline_s;
    if (deadline_s) {
      if (!(*deadline_s >= 0.0))
        throw std::invalid_argument("deadline_s: expected a number in [0, inf], got " +
                                    std::to_string(*deadline_s));
      interrupt.end =
          Interrupt::Clock::now() + std::chrono::duration_cast<Interrupt::Clock::duration>(
                                        std::chrono::duration<double>(std::min(*deadline_s, 1e6)));
    }
    Result result = [&] {
      const nb::gil_scoped_release others_run;
      const std::scoped_lock lock(mutex_);
      return run(problem, start, {&Interrupt::reached, &interrupt});
    }();
    if (interrupt.raised) throw nb::python_error();
    return result;
  }

 private:
  /// A copy of the problem for one call. Its costs are most of it, so one that no result holds any
  /// longer is taken again; the interpreter's lock is held here and where a result goes.
  std::shared_ptr<ProblemFile> spare() {
    constexpr std::size_t kMost = 4;
    for (const auto& kept : spares_) {
      if (kept.use_count() == 1) return kept;
    }
    auto made = std::make_shared<ProblemFile>(*problem_);
    if (spares_.size() < kMost) spares_.push_back(made);
    return made;
  }

  void require_start(const Result& start) const {
    const Eigen::MatrixXd& delta = solution_of(start).delta;
    const int N = problem_->sizes.N, n_copy = solver_.n_copy();
    if (delta.cols() != N || delta.rows() != n_copy)
      throw std::invalid_argument("start: expected a result whose delta has the shape (" +
                                  std::to_string(N) + ", " + std::to_string(n_copy) + "), got (" +
                                  std::to_string(delta.cols()) + ", " +
                                  std::to_string(delta.rows()) + ")");
  }

  Eigen::MatrixXd desired(nb::handle of) const {
    const c3::Sizes& sizes = problem_->sizes;
    const Numbers given = numbers(of, "xd");
    if (given.shape.size() == 1) return vector(of, "xd", sizes.n_x).replicate(1, sizes.N + 1);
    return stages(of, "xd", sizes.N + 1, sizes.n_x);
  }

  std::vector<Lcs> systems(nb::handle of) const {
    const c3::Sizes& sizes = problem_->sizes;
    std::vector<Lcs> all;
    if (nb::isinstance<Lcs>(of)) {
      all.push_back(nb::cast<const Lcs&>(of));
    } else if (!nb::try_cast(of, all) || static_cast<int>(all.size()) != sizes.N) {
      throw std::invalid_argument("lcs: expected one LCS or a list of N = " +
                                  std::to_string(sizes.N));
    }
    for (const Lcs& each : all) {
      const lcs::Sizes got = lcs::sizes(each);
      if (got.n_x != sizes.n_x || got.n_lambda != sizes.n_lambda || got.n_u != sizes.n_u) {
        const auto text = [](int n_x, int n_lambda, int n_u) {
          return "n_x " + std::to_string(n_x) + ", n_lambda " + std::to_string(n_lambda) +
                 ", n_u " + std::to_string(n_u);
        };
        throw std::invalid_argument("lcs: expected " + text(sizes.n_x, sizes.n_lambda, sizes.n_u) +
                                    ", got " + text(got.n_x, got.n_lambda, got.n_u));
      }
    }
    return all;
  }

  Result run(const Shared& problem, const Result* start, const c3::Deadline& deadline) {
    c3::Start from;
    if (start != nullptr) shift(*start->solution, problem->settings.rho, from);
    const c3::Start* given = start != nullptr ? &from : nullptr;
    const auto begin = std::chrono::steady_clock::now();
    const c3::Solution& solution =
        problem->lcs.size() == 1
            ? solver_.solve(problem->lcs.front(), problem->x0, problem->x_desired, deadline, given)
            : solver_.solve(problem->lcs, problem->x0, problem->x_desired, deadline, given);
    const double solve_time_s =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return {problem, config::to_result(*problem, solution, solve_time_s), solution,
            solution.status != c3::SolveStatus::kFailed};
  }

  Shared problem_;
  std::vector<std::shared_ptr<ProblemFile>> spares_;
  rt::WorkerPool pool_;
  c3::Solver solver_;
  std::mutex mutex_;
};

Result solve(const Problem& problem) {
  if (problem.file->method == config::Method::kC3)
    return Solver(problem).solve(nb::none(), nb::none(), nb::none(), nullptr, {});
  Interrupt interrupt;
  if (problem.file->deadline_s)
    interrupt.end = Interrupt::Clock::now() +
                    std::chrono::duration_cast<Interrupt::Clock::duration>(
                        std::chrono::duration<double>(std::min(*problem.file->deadline_s, 1e6)));
  cli::MonolithicAnswer answer = [&] {
    const nb::gil_scoped_release others_run;
    return cli::solve_monolithic(*problem.file, {&Interrupt::reached, &interrupt});
  }();
  if (interrupt.raised) throw nb::python_error();
  return {problem.file, std::move(answer.result), {}, answer.found};
}

/// One projection by itself, with the problem's weights.
struct Projected {
  Eigen::VectorXd delta;
  c3::ProjectionReport report;
};

Projected project(const Problem& problem, nb::handle v, int stage) {
  const ProblemFile& file = *problem.file;
  if (stage < 0 || stage >= file.sizes.N)
    throw std::invalid_argument("stage: expected one in [0, " + std::to_string(file.sizes.N - 1) +
                                "], got " + std::to_string(stage));
  const c3::ProjectionType& type = c3::projection_type(file.settings.projection);
  const Eigen::Index n_copy = type.make_consensus(file.sizes)->n_copy();
  const Eigen::VectorXd from = vector(v, "v", n_copy);
  const Lcs& of = file.lcs[file.lcs.size() == 1 ? 0 : static_cast<std::size_t>(stage)];
  const nb::gil_scoped_release others_run;
  const std::unique_ptr<c3::Projection> projection = c3::make_projection(file.sizes, file.settings);
  projection->set_weights(file.costs);
  projection->start(of);
  Projected out{from, {}};
  out.report = projection->project(from, out.delta, {});
  return out;
}

std::vector<std::string> projections() {
  std::vector<std::string> names;
  for (const auto type : c3::kProjectionTypes) names.emplace_back(type().problem_name);
  return names;
}

}  // namespace

Problem parse_problem(const std::string& text, const std::string& name) {
  return {std::make_shared<const ProblemFile>(config::parse_problem(text, name))};
}

void bind_problem(nb::module_& module) {
  module.def("projections", &projections, "The names of the projections, as a problem has them.");

  nb::class_<Problem>(
      module, "Problem",
      "A problem of C3, checked: what c3rt solve reads from a file. Keys, shapes and defaults are "
      "those of docs/problem_files.md, here as arguments, those of its params as well.")
      .def(
          "__init__",
          [](Problem* self, nb::handle lcs, nb::handle x0, const nb::kwargs& keys) {
            new (self) Problem(make_problem(lcs, x0, keys));
          },
          "lcs"_a, "x0"_a, "keys"_a,
          nb::sig("def __init__(self, lcs: LCS | collections.abc.Sequence[LCS], x0: "
                  "numpy.typing.ArrayLike, **keys: typing.Any) -> None"),
          "ValueError names the key, what was expected and what came.")
      .def("solve", &solve, "By its method, at most for its deadline_s.")
      .def("project", &project, "v"_a, "stage"_a = 0,
           nb::sig("def project(self, v: numpy.typing.ArrayLike, stage: int = 0) -> Projected"),
           "The problem's projection of v = [x; lam; u], with C3+ [x; lam; u; eta], onto the "
           "complementarity constraints of a stage.")
      .def_prop_ro("n_x", [](const Problem& self) { return self.file->sizes.n_x; })
      .def_prop_ro("n_lambda", [](const Problem& self) { return self.file->sizes.n_lambda; })
      .def_prop_ro("n_u", [](const Problem& self) { return self.file->sizes.n_u; })
      .def_prop_ro("N", [](const Problem& self) { return self.file->sizes.N; })
      .def_prop_ro(
          "lcs", [](const Problem& self) { return self.file->lcs; }, "One for all stages, or N.");
  module.def(
      "load_problem",
      [](const std::filesystem::path& path) {
        return Problem{std::make_shared<const ProblemFile>(config::load_problem(path.string()))};
      },
      "path"_a, "The problem of a file of c3rt solve; ValueError names file and key.");

  nb::class_<Projected>(module, "Projected")
      .def_prop_ro("delta",
                   [](nb::handle_t<Projected> self) {
                     return view(nb::cast<const Projected&>(self).delta, self);
                   })
      .def_prop_ro(
          "ok", [](const Projected& self) { return c3::has_point(self.report.status); },
          "Whether delta is a point of the set; else it is v.")
      .def_prop_ro("nodes", [](const Projected& self) { return self.report.nodes; })
      .def_prop_ro(
          "objective", [](const Projected& self) { return self.report.objective; },
          "(delta - v)' U (delta - v)");

  using c3::Iterate;
  nb::class_<Iterate>(module, "Iterate", "One turn of Algorithm 1.")
      .def_prop_ro("rho", [](const Iterate& self) { return self.rho; })
      .def_prop_ro("z", rows<Iterate>([](const Iterate& of) -> auto& { return of.z; }),
                   "(N, n_z), rows [x; lam; u], with C3+ also eta")
      .def_prop_ro(
          "x_N",
          [](nb::handle_t<Iterate> self) { return view(nb::cast<const Iterate&>(self).x_N, self); })
      .def_prop_ro("delta", rows<Iterate>([](const Iterate& of) -> auto& { return of.delta; }))
      .def_prop_ro("omega", rows<Iterate>([](const Iterate& of) -> auto& { return of.w; }),
                   "The scaled dual, after its division by rho_s.")
      .def_prop_ro("primal_residual", [](const Iterate& self) { return self.primal_residual; })
      .def_prop_ro("dual_residual", [](const Iterate& self) { return self.dual_residual; })
      .def_prop_ro("complementarity_violation",
                   [](const Iterate& self) { return self.complementarity_violation; });

  nb::class_<Result>(module, "Result", "What a solve came to: docs/problem_files.md.")
      .def_prop_ro(
          "ok", [](const Result& self) { return self.of.status == "ok"; },
          "Whether status is \"ok\".")
      .def_prop_ro(
          "found", [](const Result& self) { return self.found; },
          "Whether there is an answer, also a truncated one.")
      .def_prop_ro(
          "status", [](const Result& self) { return self.of.status; },
          "\"ok\", \"truncated\" or \"fail: why\"")
      .def_prop_ro(
          "note", [](const Result& self) { return self.of.note; }, "Why an answer is truncated.")
      .def_prop_ro("x", rows<Result>([](const Result& r) -> auto& { return r.of.x; }),
                   "(N + 1, n_x)")
      .def_prop_ro("u", rows<Result>([](const Result& r) -> auto& { return r.of.u; }), "(N, n_u)")
      .def_prop_ro("lam", rows<Result>([](const Result& r) -> auto& { return r.of.lambda; }),
                   "(N, n_lambda)")
      .def_prop_ro("delta",
                   rows<Result>([](const Result& r) -> auto& { return solution_of(r).delta; }),
                   "(N, n_z): the copies for the next QP, with C3+ also of eta")
      .def_prop_ro("omega", rows<Result>([](const Result& r) -> auto& { return solution_of(r).w; }),
                   "(N, n_z): the scaled duals for the next QP")
      .def_prop_ro(
          "objective", [](const Result& self) { return self.of.objective; },
          "The cost (14) of x and u.")
      .def_prop_ro(
          "complementarity_violation",
          [](const Result& self) { return self.of.complementarity_violation; },
          "The largest |min(lam, E x + F lam + H u + c)| of the horizon.")
      .def_prop_ro("iterations", [](const Result& self) { return self.of.iterations; })
      .def_prop_ro(
          "solve_time_s", [](const Result& self) { return self.of.solve_time_s; },
          "Of the solver alone [s].")
      .def_prop_ro(
          "trace",
          [](nb::handle_t<Result> self) {
            nb::list out;
            const auto& result = nb::cast<const Result&>(self);
            if (!result.solution) return out;
            const auto& trace = result.solution->trace;
            const auto count =
                std::min(trace.size(), static_cast<std::size_t>(result.of.iterations));
            for (std::size_t i = 0; i < count; ++i)
              out.append(nb::cast(trace[i], nb::rv_policy::reference_internal, self));
            return out;
          },
          nb::sig("def trace(self) -> list[Iterate]"), "Every turn, of a problem with trace=True.")
      .def("to_json", &Result::json, "The result file of c3rt solve.")
      .def("__repr__", [](const Result& self) {
        return "Result(status=\"" + self.of.status +
               "\", objective=" + std::to_string(self.of.objective) + ")";
      });

  nb::class_<Solver>(module, "Solver",
                     "Algorithm 1, made once for problems of the same sizes, costs and settings. "
                     "Other threads of Python run during a solve; Ctrl-C ends it.")
      .def(nb::init<const Problem&>(), "problem"_a)
      .def("solve", &Solver::solve, "x0"_a = nb::none(), "lcs"_a = nb::none(), "xd"_a = nb::none(),
           "start"_a = nb::none(), "deadline_s"_a = nb::none(),
           nb::sig("def solve(self, x0: numpy.typing.ArrayLike | None = None, lcs: LCS | "
                   "collections.abc.Sequence[LCS] | None = None, xd: numpy.typing.ArrayLike | "
                   "None = None, start: Result | None = None, deadline_s: float | None = None) -> "
                   "Result"),
           "The problem, with another state, system or target where they are given. From the "
           "copies and duals of an earlier result, one stage on, where that is given as start.");
}

}  // namespace c3rt::python
