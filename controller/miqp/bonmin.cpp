#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include <BonBonminSetup.hpp>
#include <BonCbc.hpp>
#include <BonTMINLP.hpp>
#include <CbcModel.hpp>
#include <CoinMessageHandler.hpp>

#include "controller/miqp/solver.hpp"

namespace c3rt::miqp {
namespace {

using Eigen::VectorXd;
using Ipopt::Index;
using Ipopt::Number;

constexpr double kNoBound = 1e20;  // Ipopt's infinity

void expect(bool holds, const std::string& message) {
  if (!holds) throw std::invalid_argument(message);
}

void check(const Problem& problem) {
  const auto n = problem.q.size(), m = problem.A.rows();
  const auto size = [](const char* name, Eigen::Index expected, Eigen::Index got) {
    expect(expected == got, std::string(name) + ": expected size " + std::to_string(expected) +
                                ", got " + std::to_string(got));
  };
  size("Problem.P", n, problem.P.rows());
  size("Problem.P", n, problem.P.cols());
  size("Problem.A", n, problem.A.cols());
  size("Problem.l", m, problem.l.size());
  size("Problem.u", m, problem.u.size());
  size("Problem.x_min", n, problem.x_min.size());
  size("Problem.x_max", n, problem.x_max.size());
  expect(problem.q.allFinite(), "Problem.q: expected finite numbers");
  for (const auto* matrix : {&problem.P, &problem.A}) {
    for (int column = 0; column < matrix->outerSize(); ++column) {
      for (Eigen::SparseMatrix<double>::InnerIterator entry(*matrix, column); entry; ++entry) {
        expect(std::isfinite(entry.value()), std::string("Problem.") +
                                                 (matrix == &problem.P ? "P" : "A") +
                                                 ": expected finite numbers");
      }
    }
  }
  for (const int b : problem.binaries) {
    expect(b >= 0 && b < n, "Problem.binaries: expected indices below " + std::to_string(n) +
                                ", got " + std::to_string(b));
  }
}

/// The problem as Bonmin asks for it.
class Model final : public Bonmin::TMINLP {
 public:
  explicit Model(const Problem& problem)
      : problem_(problem), lower_(problem.P.triangularView<Eigen::Lower>()) {
    lower_.makeCompressed();
    rows_ = problem.A;
    rows_.makeCompressed();
  }

  bool get_nlp_info(Index& n, Index& m, Index& nnz_jac_g, Index& nnz_h_lag,
                    Ipopt::TNLP::IndexStyleEnum& index_style) override {
    n = static_cast<Index>(problem_.q.size());
    m = static_cast<Index>(problem_.A.rows());
    nnz_jac_g = static_cast<Index>(rows_.nonZeros());
    nnz_h_lag = static_cast<Index>(lower_.nonZeros());
    index_style = Ipopt::TNLP::C_STYLE;
    return true;
  }

  bool get_variables_types(Index n, VariableType* types) override {
    std::fill_n(types, n, CONTINUOUS);
    for (const int b : problem_.binaries) types[b] = BINARY;
    return true;
  }

  bool get_variables_linearity(Index n, Ipopt::TNLP::LinearityType* types) override {
    std::fill_n(types, n, Ipopt::TNLP::LINEAR);
    for (int column = 0; column < lower_.outerSize(); ++column) {
      for (Entry entry(lower_, column); entry; ++entry) {
        types[entry.row()] = types[entry.col()] = Ipopt::TNLP::NON_LINEAR;
      }
    }
    return true;
  }

  bool get_constraints_linearity(Index m, Ipopt::TNLP::LinearityType* types) override {
    std::fill_n(types, m, Ipopt::TNLP::LINEAR);
    return true;
  }

  bool get_bounds_info(Index n, Number* x_l, Number* x_u, Index m, Number* g_l,
                       Number* g_u) override {
    const auto copy = [](const VectorXd& from, Index size, Number* to) {
      for (Index i = 0; i < size; ++i) to[i] = std::clamp(from[i], -kNoBound, kNoBound);
    };
    copy(problem_.x_min, n, x_l);
    copy(problem_.x_max, n, x_u);
    copy(problem_.l, m, g_l);
    copy(problem_.u, m, g_u);
    for (const int b : problem_.binaries) {
      x_l[b] = std::max(x_l[b], 0.0);
      x_u[b] = std::min(x_u[b], 1.0);
    }
    return true;
  }

  bool get_starting_point(Index n, bool init_x, Number* x, bool init_z, Number*, Number*, Index,
                          bool init_lambda, Number*) override {
    if (!init_x || init_z || init_lambda) return false;
    for (Index i = 0; i < n; ++i) {
      x[i] = std::max(problem_.x_min[i], std::min(0.0, problem_.x_max[i]));
    }
    return true;
  }

  bool eval_f(Index n, const Number* x, bool, Number& value) override {
    value = objective(Eigen::Map<const VectorXd>(x, n));
    return true;
  }

  bool eval_grad_f(Index n, const Number* x, bool, Number* gradient) override {
    Eigen::Map<VectorXd> result(gradient, n);
    result = 2.0 * problem_.q;
    result += 2.0 * (problem_.P * Eigen::Map<const VectorXd>(x, n));
    return true;
  }

  bool eval_g(Index n, const Number* x, bool, Index m, Number* g) override {
    Eigen::Map<VectorXd>(g, m) = rows_ * Eigen::Map<const VectorXd>(x, n);
    return true;
  }

  bool eval_jac_g(Index, const Number*, bool, Index, Index size, Index* rows, Index* columns,
                  Number* values) override {
    copy_entries(rows_, 1.0, size, rows, columns, values);
    return true;
  }

  bool eval_h(Index, const Number*, bool, Number factor, Index, const Number*, bool, Index size,
              Index* rows, Index* columns, Number* values) override {
    copy_entries(lower_, 2.0 * factor, size, rows, columns, values);
    return true;
  }

  void finalize_solution(TMINLP::SolverReturn, Index, const Number*, Number) override {}
  const BranchingInfo* branchingInfo() const override { return nullptr; }
  const SosInfo* sosConstraints() const override { return nullptr; }

  double objective(const Eigen::Ref<const VectorXd>& x) const {
    return x.dot(problem_.P * x) + 2.0 * problem_.q.dot(x) + problem_.constant;
  }

 private:
  using Entry = Eigen::SparseMatrix<double>::InnerIterator;

  static void copy_entries(const Eigen::SparseMatrix<double>& matrix, double factor, Index size,
                           Index* rows, Index* columns, Number* values) {
    if (values != nullptr) {
      for (Index i = 0; i < size; ++i) values[i] = factor * matrix.valuePtr()[i];
      return;
    }
    Index i = 0;
    for (int column = 0; column < matrix.outerSize(); ++column) {
      for (Entry entry(matrix, column); entry; ++entry, ++i) {
        rows[i] = static_cast<Index>(entry.row());
        columns[i] = static_cast<Index>(entry.col());
      }
    }
  }

  const Problem& problem_;
  Eigen::SparseMatrix<double> lower_, rows_;
};

class Silent final : public CoinMessageHandler {
 public:
  Silent() { setLogLevel(0); }
  int print() override { return 0; }
  CoinMessageHandler* clone() const override { return new Silent(*this); }
};

void configure(Bonmin::BonminSetup& setup, const Settings& settings) {
  setup.initializeOptionsAndJournalist();
  setup.readOptionsString("");  // or else it looks for bonmin.opt in the working directory
  const auto& options = setup.options();
  options->SetStringValue("bonmin.algorithm", "B-BB");
  // the default choice ends in an assertion of its own on some of our problems
  options->SetStringValue("bonmin.variable_selection", "qp-strong-branching");
  options->SetStringValue("sb", "yes");
  options->SetIntegerValue("print_level", 0);
  // for convex QPs; the line search for general ones stalls where a node is barely feasible
  options->SetStringValue("mehrotra_algorithm", "yes");
  options->SetStringValue("hessian_constant", "yes");
  options->SetStringValue("jac_c_constant", "yes");
  options->SetStringValue("jac_d_constant", "yes");
  options->SetNumericValue("tol", settings.tolerance);
  options->SetNumericValue("bonmin.allowable_fraction_gap", settings.relative_gap);
  options->SetNumericValue("bonmin.allowable_gap", settings.absolute_gap);
  options->SetNumericValue("bonmin.integer_tolerance", settings.integer_tolerance);
  options->SetIntegerValue("bonmin.node_limit", settings.max_nodes);
  options->SetNumericValue("bonmin.time_limit", settings.max_seconds);
  for (const char* level : {"bonmin.bb_log_level", "bonmin.nlp_log_level", "bonmin.lp_log_level"}) {
    options->SetIntegerValue(level, 0);
  }
}

}  // namespace

Result solve(const Problem& problem, const Settings& settings) {
  check(problem);
  Ipopt::SmartPtr<Model> model = new Model(problem);
  Result result;
  Silent silent;
  Bonmin::Bab search;
  try {
    Bonmin::BonminSetup setup(&silent);
    configure(setup, settings);
    setup.initialize(Ipopt::SmartPtr<Bonmin::TMINLP>(GetRawPtr(model)));
    search(setup);
  } catch (Bonmin::TNLPSolver::UnsolvedError* error) {  // NOLINT: thrown as a pointer
    delete error;
    return result;
  } catch (const Bonmin::OsiTMINLPInterface::SimpleError&) {
    return result;
  } catch (const CoinError&) {
    return result;
  }
  result.nodes = search.numNodes();
  if (search.bestSolution() == nullptr) {
    if (search.mipStatus() == Bonmin::Bab::ProvenInfeasible) result.status = Status::kInfeasible;
    return result;
  }
  result.x = Eigen::Map<const VectorXd>(search.bestSolution(), problem.q.size());
  result.objective = model->objective(result.x);
  const bool proven = search.mipStatus() == Bonmin::Bab::FeasibleOptimal;
  result.status = proven ? Status::kOptimal : Status::kFeasible;
  const double gap =
      (result.objective - search.bestBound()) / std::max(std::abs(result.objective), 1.0);
  result.gap = std::max(gap, 0.0);
  return result;
}

}  // namespace c3rt::miqp
