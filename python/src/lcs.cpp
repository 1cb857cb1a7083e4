// Linear complementarity systems and their simulation.
#include "controller/lcs/lcs.hpp"

#include <stdexcept>
#include <string>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include "controller/lcs/lemke.hpp"
#include "controller/lcs/simulate.hpp"
#include "controller/lcs/step.hpp"
#include "python/src/arrays.hpp"
#include "python/src/bind.hpp"

namespace c3rt::python {
namespace {

using lcs::Lcs;
using namespace nb::literals;

Lcs make(nb::handle A, nb::handle B, nb::handle D, nb::handle d, nb::handle E, nb::handle F,
         nb::handle H, nb::handle c) {
  Lcs of;
  of.A = matrix(A, "LCS.A", kAnySize, kAnySize);
  of.B = matrix(B, "LCS.B", kAnySize, kAnySize);
  of.F = matrix(F, "LCS.F", kAnySize, kAnySize);
  const Eigen::Index n_x = of.A.rows(), n_u = of.B.cols(), n_lambda = of.F.rows();
  of.A = matrix(A, "LCS.A", n_x, n_x);
  of.B = matrix(B, "LCS.B", n_x, n_u);
  of.D = matrix(D, "LCS.D", n_x, n_lambda);
  of.d = vector(d, "LCS.d", n_x);
  of.E = matrix(E, "LCS.E", n_lambda, n_x);
  of.F = matrix(F, "LCS.F", n_lambda, n_lambda);
  of.H = matrix(H, "LCS.H", n_lambda, n_u);
  of.c = vector(c, "LCS.c", n_lambda);
  check(of);
  return of;
}

const char* why(lcs::LcpStatus status) {
  switch (status) {
    case lcs::LcpStatus::kRay:
      return "Lemke's method ended on a ray, as where there is no solution";
    case lcs::LcpStatus::kPivotLimit:
      return "Lemke's method came to its bound of pivots";
    case lcs::LcpStatus::kInaccurate:
      return "of the solution no digits are left";
    case lcs::LcpStatus::kSolved:
      break;
  }
  return "";
}

nb::tuple step(const Lcs& of, nb::handle x, nb::handle u) {
  const Eigen::VectorXd from = vector(x, "x", of.A.rows());
  const Eigen::VectorXd input = vector(u, "u", of.B.cols());
  Eigen::VectorXd next(of.A.rows()), lambda(of.F.rows());
  lcs::StepReport report{};
  {
    const nb::gil_scoped_release others_run;
    lcs::Lemke lemke(static_cast<int>(of.F.rows()));
    report = lcs::step(of, from, input, lemke, next, lambda);
  }
  if (!report.ok())
    throw std::runtime_error(std::string("the LCP at x and u: ") + why(report.lcp.status));
  return nb::make_tuple(copy(next), copy(lambda));
}

using OneOrMore = std::variant<Lcs, std::vector<Lcs>>;

lcs::Simulation simulate(const OneOrMore& of, nb::handle x_0, nb::handle u) {
  const auto* each = std::get_if<std::vector<Lcs>>(&of);
  if (each != nullptr && each->empty())
    throw std::invalid_argument("lcs: expected one system or one for each step, got none");
  const Lcs& first = each != nullptr ? each->front() : std::get<Lcs>(of);
  const Eigen::VectorXd start = vector(x_0, "x0", first.A.rows());
  const Eigen::MatrixXd inputs = stages(
      u, "u", each != nullptr ? static_cast<Eigen::Index>(each->size()) : kAnySize, first.B.cols());
  const nb::gil_scoped_release others_run;
  return each != nullptr ? lcs::simulate(*each, start, inputs)
                         : lcs::simulate(first, start, inputs);
}

template <auto Member>
Array block(nb::handle_t<Lcs> self) {
  return view(nb::cast<const Lcs&>(self).*Member, self);
}

}  // namespace

void bind_lcs(nb::module_& module) {
  nb::class_<Lcs>(module, "LCS",
                  "One step of a discrete-time linear complementarity system:\n\n"
                  "    x+ = A x + B u + D lam + d,   0 <= lam  _|_  E x + F lam + H u + c >= 0")
      .def(
          "__init__",
          [](Lcs* self, nb::handle A, nb::handle B, nb::handle D, nb::handle d, nb::handle E,
             nb::handle F, nb::handle H,
             nb::handle c) { new (self) Lcs(make(A, B, D, d, E, F, H, c)); },
          "A"_a, "B"_a, "D"_a, "d"_a, "E"_a, "F"_a, "H"_a, "c"_a,
          nb::sig("def __init__(self, A: numpy.typing.ArrayLike, B: numpy.typing.ArrayLike, "
                  "D: numpy.typing.ArrayLike, d: numpy.typing.ArrayLike, "
                  "E: numpy.typing.ArrayLike, F: numpy.typing.ArrayLike, "
                  "H: numpy.typing.ArrayLike, c: numpy.typing.ArrayLike) -> None"),
          "ValueError names the block whose shape does not fit, or that is not finite.")
      .def_prop_ro("A", block<&Lcs::A>, "(n_x, n_x)")
      .def_prop_ro("B", block<&Lcs::B>, "(n_x, n_u)")
      .def_prop_ro("D", block<&Lcs::D>, "(n_x, n_lambda)")
      .def_prop_ro("d", block<&Lcs::d>, "(n_x,)")
      .def_prop_ro("E", block<&Lcs::E>, "(n_lambda, n_x)")
      .def_prop_ro("F", block<&Lcs::F>, "(n_lambda, n_lambda)")
      .def_prop_ro("H", block<&Lcs::H>, "(n_lambda, n_u)")
      .def_prop_ro("c", block<&Lcs::c>, "(n_lambda,)")
      .def_prop_ro("n_x", [](const Lcs& self) { return self.A.rows(); })
      .def_prop_ro("n_u", [](const Lcs& self) { return self.B.cols(); })
      .def_prop_ro("n_lambda", [](const Lcs& self) { return self.F.rows(); })
      .def("step", &step, "x"_a, "u"_a,
           nb::sig("def step(self, x: numpy.typing.ArrayLike, u: numpy.typing.ArrayLike) -> "
                   "tuple[numpy.typing.NDArray, numpy.typing.NDArray]"),
           "The next state and lam of one step, its LCP solved by Lemke's method; RuntimeError "
           "where that finds no solution.")
      .def("__repr__", [](const Lcs& self) {
        return "LCS(n_x=" + std::to_string(self.A.rows()) +
               ", n_lambda=" + std::to_string(self.F.rows()) +
               ", n_u=" + std::to_string(self.B.cols()) + ")";
      });

  using lcs::Simulation;
  nb::class_<Simulation>(module, "Simulation", "The steps that succeeded.")
      .def_prop_ro(
          "x",
          [](nb::handle_t<Simulation> self) {
            return view_stages(nb::cast<const Simulation&>(self).x, self);
          },
          "(steps + 1, n_x), from x0 on")
      .def_prop_ro(
          "lam",
          [](nb::handle_t<Simulation> self) {
            return view_stages(nb::cast<const Simulation&>(self).lambda, self);
          },
          "(steps, n_lambda)")
      .def_prop_ro("steps", [](const Simulation& self) { return self.report.steps; })
      .def_prop_ro(
          "ok", [](const Simulation& self) { return self.report.ok(); }, "Whether all succeeded.")
      .def_prop_ro(
          "why", [](const Simulation& self) { return std::string(why(self.report.lcp.status)); },
          "Why the step after the last one did not; \"\" where all succeeded.")
      .def_prop_ro(
          "residual", [](const Simulation& self) { return self.report.residual; },
          "The largest |min(lam, E x + F lam + H u + c)|.");
  module.def("simulate", &simulate, "lcs"_a, "x0"_a, "u"_a,
             nb::sig("def simulate(lcs: LCS | collections.abc.Sequence[LCS], x0: "
                     "numpy.typing.ArrayLike, u: numpy.typing.ArrayLike) -> Simulation"),
             "From x0 with the inputs u (N, n_u), one step each, of one system or of one for each "
             "step. It ends before a step whose LCP has no answer.");
}

}  // namespace c3rt::python
