#pragma once
// What `c3rt lcs inspect` says of any model.
#include <string>
#include <vector>

#include <Eigen/Core>

#include "controller/lcs/lcs.hpp"
#include "controller/model/block_errors.hpp"
#include "controller/scene/object.hpp"

namespace c3rt::cli {

/// Of what moves where the blocks are checked in motion [m/s], [rad/s].
constexpr double kInspectedSpeed = 0.1, kInspectedTurn = 1.0;

/// "box of 160 x 40 x 40 mm"
std::string describe(const scene::Shape& shape);

/// To three digits after the point, so that no -0.000 is printed.
double rounded(double value);

/// Mass, inertia, size and parts. @param warnings gets what a person should mind
void print_object(const scene::Object& object, std::vector<std::string>& warnings);

/// Of F, and of the system with its forces scaled.
void print_conditioning(const lcs::Lcs& lcs);

void print_error_heading();
void print_error_row(const std::string& name, const model::BlockErrors& errors);
void warn_of_errors(const model::BlockErrors& resting, const model::BlockErrors& turning,
                    std::vector<std::string>& warnings);

void print_warnings(const std::vector<std::string>& warnings);

/// A problem of `c3rt solve`, by C3+.
/// @param Q  the diagonal  @param u_min,u_max  ±infinity: none
std::string problem_file(const lcs::Lcs& lcs, const Eigen::VectorXd& x0, const Eigen::VectorXd& Q,
                         const Eigen::VectorXd& x_desired, const Eigen::VectorXd& u_min,
                         const Eigen::VectorXd& u_max);

}  // namespace c3rt::cli
