#pragma once
// Where a task's parameters come from: a scenario's section, or whatever else names numbers.
#include <string>
#include <vector>

#include <Eigen/Core>

namespace c3rt::task {

/// Each call names one parameter and what it may be; a parameter that is missing or is not that
/// makes the source throw an error of its own, which names it.
class Source {
 public:
  virtual ~Source() = default;
  /// Whether a parameter that need not be there is.
  virtual bool has(const std::string& key) = 0;
  virtual double number(const std::string& key, double min, double max) = 0;
  virtual bool boolean(const std::string& key) = 0;
  /// Exactly `size` numbers.
  virtual Eigen::VectorXd numbers(const std::string& key, int size, double min, double max) = 0;
  /// One number for all, or `size` numbers.
  virtual Eigen::VectorXd one_or_each(const std::string& key, int size, double min, double max) = 0;
  /// `min_rows` to `max_rows` lists of `columns` numbers each, as (rows × columns).
  virtual Eigen::MatrixXd rows(const std::string& key, int min_rows, int max_rows, int columns,
                               double min, double max) = 0;
  /// The index of the chosen one.
  virtual int choice(const std::string& key, const std::vector<std::string>& names) = 0;
  [[noreturn]] virtual void fail(const std::string& key, const std::string& expected,
                                 const std::string& got) = 0;
};

}  // namespace c3rt::task
