#pragma once
// JSON -> numbers and matrices, strictly: what is missing, unknown, of the wrong type or size is
// refused with file, key and what was expected.
#include <set>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "config/section.hpp"
#include "controller/c3/problem.hpp"

namespace c3rt::config {

/// One object of a JSON file, which must outlive this.
class JsonReader {
 public:
  /// @param path of the object inside the file, for messages
  /// @throws ConfigError as everything below, here unless it is an object
  JsonReader(const nlohmann::json& json, std::string file, std::string path);

  bool has(const char* key);
  const nlohmann::json& at(const char* key);
  // those with `missing` give that where the key is not there

  double number(const char* key, double min, double max);
  double number(const char* key, double min, double max, double missing);
  int integer(const char* key, int min, int max);
  int integer(const char* key, int min, int max, int missing);
  bool boolean(const char* key, bool missing);
  /// The index of the value among the choices.
  std::size_t choice(const char* key, const std::vector<std::string>& choices);
  std::size_t choice(const char* key, const std::vector<std::string>& choices, std::size_t missing);
  Eigen::VectorXd vector(const char* key, Eigen::Index size);
  Eigen::VectorXd vector(const std::string& key, const nlohmann::json& value,
                         Eigen::Index size) const;
  /// A list of rows. Without rows or columns it is [], or as many empty rows as it has. With
  /// kAnyRows as many as there are.
  static constexpr Eigen::Index kAnyRows = -1;
  Eigen::MatrixXd matrix(const char* key, Eigen::Index rows, Eigen::Index cols);
  Eigen::MatrixXd matrix(const std::string& key, const nlohmann::json& value, Eigen::Index rows,
                         Eigen::Index cols) const;
  /// A matrix for all stages, or a list of N.
  c3::PerStage<Eigen::MatrixXd> matrices(const char* key, Eigen::Index rows, Eigen::Index cols,
                                         int N);
  /// A list of numbers where null is no bound; empty if the key is missing or null.
  Eigen::VectorXd bound(const std::string& key, const nlohmann::json& value, Eigen::Index size,
                        double none) const;
  /// Bounds of a stage, or of each: lists of them for k = 0 … N−1, of sizes[k] numbers. With
  /// `of_state` also for k = 1 … N−1 (N−1 lists), or with the last state's (N+1 lists, the last
  /// into `last`).
  c3::PerStage<Eigen::VectorXd> bounds(const char* key, const std::vector<Eigen::Index>& sizes,
                                       double none, bool of_state = false,
                                       Eigen::VectorXd* last = nullptr);
  /// One number for all, or a list.
  Eigen::VectorXd numbers(const char* key, Eigen::Index size);
  /// Refuses the keys that nobody asked for.
  void finish() const;

  /// "problem.json: params.G"
  std::string place(const std::string& key) const;

 private:
  double as_number(const std::string& key, const nlohmann::json& value, double min,
                   double max) const;
  void require_list(const std::string& key, const nlohmann::json& value,
                    const std::string& expected) const;
  /// A list of `size` values; `what` they are.
  void require_values(const std::string& key, const nlohmann::json& value, Eigen::Index size,
                      const std::string& what) const;
  [[noreturn]] void fail(const std::string& key, const std::string& expected,
                         const nlohmann::json& got) const;

  const nlohmann::json& json_;
  std::string file_, path_;
  std::set<std::string> used_;
};

/// The file's content. NaN and infinity, which are no JSON, become strings, so that they are
/// refused by the key that has them; a key that an object has twice is refused.
/// @throws ConfigError
nlohmann::json parse_json(const std::string& text, const std::string& name);

}  // namespace c3rt::config
