#include "python/src/arrays.hpp"

#include <cmath>
#include <cstdint>
#include <memory>
#include <stdexcept>

namespace c3rt::python {
namespace {

using Given = nb::ndarray<const double, nb::device::cpu>;

std::string text(const std::vector<std::string>& axes) {
  std::string out = "(";
  for (std::size_t i = 0; i < axes.size(); ++i)
    out += axes[i] + (i + 1 < axes.size() ? ", " : axes.size() == 1 ? "," : "");
  return out + ")";
}

std::string text(const std::vector<std::size_t>& shape) {
  std::vector<std::string> axes;
  for (const std::size_t n : shape) axes.push_back(std::to_string(n));
  return text(axes);
}

/// The array itself where it is one of doubles, else what numpy makes of it.
Given given(nb::handle from, const std::string& name) {
  Given array;
  if (nb::try_cast(from, array, false)) return array;
  nb::object made;
  std::string type;
  try {
    made = nb::module_::import_("numpy").attr("asarray")(from);
    const nb::object dtype = made.attr("dtype"), name_of = dtype.attr("name"),
                     kind_of = dtype.attr("kind");
    type = nb::cast<std::string>(name_of);
    const auto kind = nb::cast<std::string>(kind_of);
    if (kind == "f" || kind == "i" || kind == "u" || kind == "b")
      made = made.attr("astype")("float64");
  } catch (nb::python_error&) {
    throw std::invalid_argument(name + ": expected an array of real numbers, got what is none");
  }
  if (!nb::try_cast(made, array, false))
    throw std::invalid_argument(name + ": expected real numbers, got an array of " + type);
  return array;
}

std::vector<std::size_t> shape_of(const Given& array) {
  std::vector<std::size_t> shape;
  for (std::size_t i = 0; i < array.ndim(); ++i) shape.push_back(array.shape(i));
  return shape;
}

void require_shape(const Given& array, const std::string& name,
                   std::initializer_list<Eigen::Index> expected) {
  bool fits = array.ndim() == expected.size();
  std::vector<std::string> axes;
  for (const Eigen::Index n : expected) {
    const std::size_t axis = axes.size();
    fits = fits && (n == kAnySize || array.shape(axis) == static_cast<std::size_t>(n));
    axes.push_back(n == kAnySize ? "any" : std::to_string(n));
  }
  if (!fits)
    throw std::invalid_argument(name + ": expected the shape " + text(axes) + ", got " +
                                text(shape_of(array)));
}

void require_finite(double value, const std::string& name) {
  if (!std::isfinite(value))
    throw std::invalid_argument(name + ": expected finite numbers, got " + std::to_string(value));
}

Array view_of(const double* data, std::initializer_list<std::size_t> shape,
              std::initializer_list<std::int64_t> strides, nb::handle owner) {
  static const double nothing = 0.0;  // an array without entries still has an address
  return {data != nullptr ? data : &nothing, shape, owner, strides};
}

}  // namespace

Numbers numbers(nb::handle from, const std::string& name) {
  const Given array = given(from, name);
  Numbers out{{}, shape_of(array)};
  if (array.ndim() > 3)
    throw std::invalid_argument(name + ": expected at most three axes, got the shape " +
                                text(out.shape));
  // as if there were three axes, those before the array's of size one
  std::size_t size[3] = {1, 1, 1};
  std::int64_t stride[3] = {0, 0, 0};
  for (std::size_t i = 0; i < array.ndim(); ++i) {
    size[3 - array.ndim() + i] = array.shape(i);
    stride[3 - array.ndim() + i] = array.stride(i);
  }
  out.values.reserve(array.size());
  for (std::size_t i = 0; i < size[0]; ++i)
    for (std::size_t j = 0; j < size[1]; ++j)
      for (std::size_t k = 0; k < size[2]; ++k)
        out.values.push_back(array.data()[static_cast<std::int64_t>(i) * stride[0] +
                                          static_cast<std::int64_t>(j) * stride[1] +
                                          static_cast<std::int64_t>(k) * stride[2]]);
  return out;
}

Eigen::VectorXd vector(nb::handle from, const std::string& name, Eigen::Index size) {
  const Given array = given(from, name);
  require_shape(array, name, {size});
  Eigen::VectorXd out(static_cast<Eigen::Index>(array.shape(0)));
  for (Eigen::Index i = 0; i < out.size(); ++i) {
    out[i] = array.data()[i * array.stride(0)];
    require_finite(out[i], name);
  }
  return out;
}

Eigen::MatrixXd matrix(nb::handle from, const std::string& name, Eigen::Index rows,
                       Eigen::Index cols) {
  const Given array = given(from, name);
  require_shape(array, name, {rows, cols});
  Eigen::MatrixXd out(static_cast<Eigen::Index>(array.shape(0)),
                      static_cast<Eigen::Index>(array.shape(1)));
  for (Eigen::Index j = 0; j < out.cols(); ++j) {
    for (Eigen::Index i = 0; i < out.rows(); ++i) {
      out(i, j) = array.data()[i * array.stride(0) + j * array.stride(1)];
      require_finite(out(i, j), name);
    }
  }
  return out;
}

Eigen::MatrixXd stages(nb::handle from, const std::string& name, Eigen::Index count,
                       Eigen::Index size) {
  return matrix(from, name, count, size).transpose();
}

Array view(const Eigen::VectorXd& of, nb::handle owner) {
  return view_of(of.data(), {static_cast<std::size_t>(of.size())}, {1}, owner);
}

Array view(const Eigen::MatrixXd& of, nb::handle owner) {
  return view_of(of.data(),
                 {static_cast<std::size_t>(of.rows()), static_cast<std::size_t>(of.cols())},
                 {1, of.rows()}, owner);
}

Array view_stages(const Eigen::MatrixXd& of, nb::handle owner) {
  return view_of(of.data(),
                 {static_cast<std::size_t>(of.cols()), static_cast<std::size_t>(of.rows())},
                 {of.rows(), 1}, owner);
}

namespace {

/// An array that has the numbers of `of` for itself.
template <typename Eigens>
nb::object copy_of(const Eigens& of, std::vector<std::size_t> shape) {
  auto kept = std::make_unique<Eigens>(of);
  double* data = kept->data();
  const nb::capsule owner(kept.release(), [](void* numbers) noexcept {
    std::unique_ptr<Eigens>(static_cast<Eigens*>(numbers)).reset();
  });
  static double nothing = 0.0;
  return nb::cast(nb::ndarray<nb::numpy, double>(data != nullptr ? data : &nothing, shape.size(),
                                                 shape.data(), owner));
}

}  // namespace

nb::object copy(const Eigen::VectorXd& of) {
  return copy_of(of, {static_cast<std::size_t>(of.size())});
}

nb::object copy_stages(const Eigen::MatrixXd& of) {
  return copy_of(of, {static_cast<std::size_t>(of.cols()), static_cast<std::size_t>(of.rows())});
}

}  // namespace c3rt::python
