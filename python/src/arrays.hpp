#pragma once
// Numbers of Python as Eigen's, and back.
#include <string>
#include <vector>

#include <Eigen/Core>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
// for all sources alike: what a type is in Python is one thing
#include <nanobind/stl/string.h>

namespace c3rt::python {

namespace nb = nanobind;

/// Real numbers with one to three axes, copied out of whatever numpy makes an array of.
struct Numbers {
  std::vector<double> values;  // the last axis runs fastest
  std::vector<std::size_t> shape;
};

/// @param name of the argument, for the message
/// @throws std::invalid_argument "x0: expected real numbers, got an array of complex128"
Numbers numbers(nb::handle from, const std::string& name);

constexpr Eigen::Index kAnySize = -1;

/// @throws std::invalid_argument "x0: expected the shape (4,), got (3,)", "x0: expected finite
/// numbers, got nan"
Eigen::VectorXd vector(nb::handle from, const std::string& name, Eigen::Index size);
/// @throws the same: "LCS.E: expected the shape (1, 2), got (1, 3)"
Eigen::MatrixXd matrix(nb::handle from, const std::string& name, Eigen::Index rows,
                       Eigen::Index cols);
/// One row a stage in Python, one column a stage here.
Eigen::MatrixXd stages(nb::handle from, const std::string& name, Eigen::Index count,
                       Eigen::Index size);

using Array = nb::ndarray<nb::numpy, const double>;

/// What cannot be written to, and keeps `owner` alive, which has the memory.
Array view(const Eigen::VectorXd& of, nb::handle owner);
Array view(const Eigen::MatrixXd& of, nb::handle owner);
/// A column here is a row in Python.
Array view_stages(const Eigen::MatrixXd& of, nb::handle owner);
/// An array with memory of its own.
nb::object copy(const Eigen::VectorXd& of);
/// The same of a matrix: a column here is a row in Python.
nb::object copy_stages(const Eigen::MatrixXd& of);

}  // namespace c3rt::python
