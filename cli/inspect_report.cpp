#include "cli/inspect_report.hpp"

#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cli/matrix_json.hpp"
#include "cli/millimetres.hpp"
#include "controller/scene/distance.hpp"

namespace c3rt::cli {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

double extent(const scene::Object& object, const Vector3d& along) {
  return scene::reach(object.shape(), along) + scene::reach(object.shape(), -along);
}

/// Of two parts MuJoCo adds up the masses, whether they overlap or not.
void warn_of_overlap(const scene::Object& object, std::vector<std::string>& warnings) {
  const std::vector<scene::Part>& parts = object.parts->parts;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    for (std::size_t j = i + 1; j < parts.size(); ++j) {
      const double gap = scene::separation(parts[i].shape, {parts[i].p_BP, parts[i].R_BP},
                                           parts[j].shape, {parts[j].p_BP, parts[j].R_BP})
                             .distance;
      if (gap >= -0.1 * kMillimetre) continue;
      warnings.push_back(fmt::format(
          "{}: its parts {} and {} overlap by {:.3g} mm: unless the file gives the inertia, what "
          "they share has been weighed twice",
          object.name, i + 1, j + 1, -gap / kMillimetre));
    }
  }
}

nlohmann::json to_json(const MatrixXd& matrix) { return rows_of<nlohmann::json>(matrix); }

nlohmann::json to_json(const VectorXd& vector) {
  nlohmann::json values = nlohmann::json::array();
  for (const double value : vector) values.push_back(value);
  return values;
}

/// A list where null is no bound.
nlohmann::json bounds(const VectorXd& of) {
  nlohmann::json values = nlohmann::json::array();
  for (const double value : of)
    values.push_back(std::isfinite(value) ? nlohmann::json(value) : nlohmann::json());
  return values;
}

}  // namespace

std::string describe(const scene::Shape& shape) {
  const auto mm = [](double length) { return length / kMillimetre; };
  switch (shape.kind) {
    case scene::ShapeKind::kSphere:
      return fmt::format("sphere of radius {:.4g} mm", mm(shape.radius));
    case scene::ShapeKind::kBox:
      return fmt::format("box of {:.4g} x {:.4g} x {:.4g} mm", mm(2 * shape.half_sizes.x()),
                         mm(2 * shape.half_sizes.y()), mm(2 * shape.half_sizes.z()));
    case scene::ShapeKind::kCapsule:
    case scene::ShapeKind::kCylinder:
      return fmt::format("{} of radius {:.4g} mm and {} {:.4g} mm",
                         shape.kind == scene::ShapeKind::kCapsule ? "capsule" : "cylinder",
                         mm(shape.radius),
                         shape.kind == scene::ShapeKind::kCapsule ? "straight part" : "length",
                         mm(2 * shape.half_length));
    case scene::ShapeKind::kConvexMesh:
      return fmt::format("convex hull of {} corners and {} faces", shape.mesh->vertices().size(),
                         shape.mesh->faces().size());
    case scene::ShapeKind::kUnion:
      break;
  }
  return "several parts";
}

double rounded(double value) { return std::round(1e3 * value) / 1e3 + 0.0; }

void print_object(const scene::Object& object, std::vector<std::string>& warnings) {
  const Vector3d principal =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(object.inertia).eigenvalues();
  fmt::print("  {}: mass {:.4g} kg, principal inertia {:.3g} {:.3g} {:.3g} kg m2", object.name,
             object.mass, principal[0], principal[1], principal[2]);
  if (object.parts->parts.empty()) {
    fmt::print(", nothing that can touch\n");
    return;
  }
  fmt::print(", friction {:.3g}, {:.4g} x {:.4g} x {:.4g} mm\n", object.friction,
             extent(object, Vector3d::UnitX()) / kMillimetre,
             extent(object, Vector3d::UnitY()) / kMillimetre,
             extent(object, Vector3d::UnitZ()) / kMillimetre);
  for (const scene::Part& part : object.parts->parts) {
    fmt::print("    {} at {:.4g} {:.4g} {:.4g} mm from the centre of mass\n", describe(part.shape),
               millimetres(part.p_BP.x()), millimetres(part.p_BP.y()), millimetres(part.p_BP.z()));
  }
  // a rod along its own axis, say: Euler's equation has no answer to a turn about it
  if (principal[0] < 1e-9 * principal[2])
    warnings.push_back(object.name + ": one principal inertia is next to nothing");
  warn_of_overlap(object, warnings);
}

void print_conditioning(const lcs::Lcs& lcs) {
  const VectorXd of_F = Eigen::JacobiSVD<MatrixXd>(lcs.F).singularValues();
  const auto rank = [](const VectorXd& values) {
    return (values.array() > 1e-9 * values[0]).count();
  };
  const Eigen::Index n_F = rank(of_F);
  const double symmetric = (lcs.F - lcs.F.transpose()).cwiseAbs().maxCoeff();
  const double least =
      Eigen::SelfAdjointEigenSolver<MatrixXd>(0.5 * (lcs.F + lcs.F.transpose())).eigenvalues()[0];
  fmt::print("conditioning\n  F: rank {} of {}, singular values {:.3g} to {:.3g}, {}\n", n_F,
             lcs.F.rows(), of_F[n_F - 1], of_F[0],
             symmetric > 1e-12 * of_F[0] ? "not symmetric"
             : least > -1e-9 * of_F[0]   ? "symmetric, positive semidefinite"
                                         : "symmetric, indefinite");
  const double scale = lcs::force_scale(lcs);
  lcs::Lcs scaled = lcs;
  lcs::scale_forces(scaled, scale);
  MatrixXd ABD(lcs.A.rows(), lcs.A.cols() + lcs.B.cols() + lcs.D.cols());
  ABD << scaled.A, scaled.B, scaled.D;
  const VectorXd of_ABD = Eigen::JacobiSVD<MatrixXd>(ABD).singularValues();
  fmt::print("  scaled by {:.3g}: |D| {:.3g} beside |A| {:.3g}, [A B D] from {:.3g} to {:.3g}\n",
             scale, scaled.D.norm(), scaled.A.norm(), of_ABD[rank(of_ABD) - 1], of_ABD[0]);
}

void print_error_heading() {
  fmt::print(
      "error of each block against finite differences of the step (relative; d and c: of x "
      "and eta)\n  {:<34}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}\n",
      "", "A", "B", "D", "d", "E", "F", "H", "c");
}

void print_error_row(const std::string& name, const model::BlockErrors& e) {
  fmt::print("  {:<34}{:>9.1e}{:>9.1e}{:>9.1e}{:>9.1e}{:>9.1e}{:>9.1e}{:>9.1e}{:>9.1e}\n", name,
             e.A, e.B, e.D, e.d, e.E, e.F, e.H, e.c);
}

void warn_of_errors(const model::BlockErrors& resting, const model::BlockErrors& turning,
                    std::vector<std::string>& warnings) {
  if (resting.E > 0.05) {
    warnings.push_back(fmt::format(
        "E is off by {:.0f} % at rest: the LCS holds normals and lever arms still while an object "
        "turns; linearise anew every period",
        100.0 * resting.E));
  }
  if (turning.A > 0.1)
    warnings.emplace_back("A is off by more than 10 % where it turns: a shorter step is nearer");
}

void print_warnings(const std::vector<std::string>& warnings) {
  if (!warnings.empty()) fmt::print("mind\n");
  for (const std::string& warning : warnings) fmt::print("  - {}\n", warning);
}

std::string problem_file(const lcs::Lcs& lcs, const VectorXd& x0, const VectorXd& Q,
                         const VectorXd& x_desired, const VectorXd& u_min, const VectorXd& u_max) {
  const MatrixXd of_x = Q.asDiagonal();
  nlohmann::json problem{
      {"schema", "c3-problem-1"},
      {"lcs",
       {{"A", to_json(lcs.A)},
        {"B", to_json(lcs.B)},
        {"D", to_json(lcs.D)},
        {"d", to_json(lcs.d)},
        {"E", to_json(lcs.E)},
        {"F", to_json(lcs.F)},
        {"H", to_json(lcs.H)},
        {"c", to_json(lcs.c)}}},
      {"x0", to_json(x0)},
      {"projection", "C3+"},
      {"params",
       {{"N", 10},
        {"s", 2},
        {"rho", 1.0},
        {"rho_s", 3.0},
        {"Q", to_json(of_x)},
        {"R", to_json(MatrixXd(1e-5 * MatrixXd::Identity(lcs.B.cols(), lcs.B.cols())))},
        {"QN", to_json(of_x)},
        {"xd", to_json(x_desired)},
        {"delta0", "x0"},
        {"u_lambda", 10.0},
        {"u_eta", 1.0},
        {"g_lambda", 0.1},
        {"g_eta", 0.01}}}};
  if (u_min.array().isFinite().any() || u_max.array().isFinite().any()) {
    problem["params"]["umin"] = bounds(u_min);
    problem["params"]["umax"] = bounds(u_max);
  }
  return problem.dump(1) + "\n";
}

}  // namespace c3rt::cli
