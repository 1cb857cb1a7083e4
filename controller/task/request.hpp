#pragma once
// A task as a client names it: a kind and named parameters, read by the same loaders as a
// scenario's.
#include <stdexcept>
#include <string>
#include <vector>

#include "controller/task/source.hpp"

namespace c3rt::task {

struct Parameter {
  std::string name;
  std::vector<double> values;  // one of a number, all of a list, row after row of a list of lists;
                               // 0 or 1 of a truth value
  std::string word;            // of a parameter that names one of several; empty: it has values
};

struct Request {
  std::string kind;
  std::vector<Parameter> parameters;
};

/// Says what was expected and what came.
class RequestError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// A parameter as a person writes it: "radius_m=0.08", "center_m=0.55,0", "preview=true",
/// "between=hold".
/// @throws RequestError for what has no name or no value
Parameter parse_parameter(const std::string& text);

/// Every parameter must be read once; finish() refuses what nobody read.
class RequestSource final : public Source {
 public:
  explicit RequestSource(const Request& request) : request_(request) {}

  bool has(const std::string& key) override;
  double number(const std::string& key, double min, double max) override;
  bool boolean(const std::string& key) override;
  Eigen::VectorXd numbers(const std::string& key, int size, double min, double max) override;
  Eigen::VectorXd one_or_each(const std::string& key, int size, double min, double max) override;
  Eigen::MatrixXd rows(const std::string& key, int min_rows, int max_rows, int columns, double min,
                       double max) override;
  int choice(const std::string& key, const std::vector<std::string>& names) override;
  [[noreturn]] void fail(const std::string& key, const std::string& expected,
                         const std::string& got) override;
  /// @throws RequestError naming a parameter that is none of the kind's, or is given twice
  void finish() const;

 private:
  const Parameter& find(const std::string& key, const std::string& expected);
  const std::vector<double>& values(const std::string& key, const std::string& expected, double min,
                                    double max);

  const Request& request_;
  std::vector<std::string> asked_;
};

}  // namespace c3rt::task
