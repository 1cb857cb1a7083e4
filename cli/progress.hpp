#pragma once
// How far a computation in this process has come.
#include <functional>
#include <string>

namespace c3rt::cli {

/// Whether a person wants this to end.
using Stop = std::function<bool()>;

/// One line on standard error that is drawn over on a terminal, elsewhere a line every ten seconds;
/// nothing in the first second.
class Progress {
 public:
  explicit Progress(std::string title);
  ~Progress();  // clears the line
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Call it often; it draws when it is time.
  /// @param share done so far, 0 … 1
  void update(double share, const std::string& text);
  /// Of what has no known end.
  void update(const std::string& text);
  /// A line that stays, above the one that is drawn over.
  void say(const std::string& line);

 private:
  bool is_time();
  void draw(const std::string& line);

  std::string title_;
  bool terminal_;
  bool drawn_ = false;
  double started_, drawn_at_;  // [s]
};

/// Seconds of a clock that only runs forwards.
double seconds_now();

/// Seconds that this thread has had of a core: what other programs take meanwhile does not count.
double processor_seconds_now();

}  // namespace c3rt::cli
