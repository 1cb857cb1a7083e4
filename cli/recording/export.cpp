#include "cli/recording/export.hpp"

#include <algorithm>
#include <memory>
#include <tuple>

#include "cli/recording/csv.hpp"

namespace c3rt::cli {
namespace {

/// Writes the tables of the topics that are wanted, each when its first sample comes.
template <typename Types>
class Exporting;
template <typename... T>
class Exporting<std::tuple<T...>> : public Listener {
 public:
  Exporting(const std::filesystem::path& folder, const std::vector<std::string>& topics)
      : folder_(folder), topics_(topics) {}
#define C3RT_TOPIC(Type, ...) \
  void hear(const wire::Type& sample) override { add(sample); }
  C3RT_TOPICS(C3RT_TOPIC)
#undef C3RT_TOPIC

  void finish() {
    std::apply([](auto&... csv) { ((csv ? csv->finish() : void()), ...); }, all_);
  }

 private:
  template <typename U>
  void add(const U& sample) {
    auto& csv = std::get<std::unique_ptr<TopicCsv<U>>>(all_);
    if (!csv) {
      const bool wanted = topics_.empty() || std::find(topics_.begin(), topics_.end(),
                                                       wire::topic<U>().name) != topics_.end();
      if (!wanted) return;
      csv = std::make_unique<TopicCsv<U>>(folder_);
    }
    csv->add(sample);
  }

  std::filesystem::path folder_;
  const std::vector<std::string>& topics_;
  std::tuple<std::unique_ptr<TopicCsv<T>>...> all_;
};

}  // namespace

Contents write_csv(const std::filesystem::path& file, const std::vector<std::string>& topics,
                   const std::filesystem::path& folder) {
  Exporting<wire::TopicTypes> exporting(folder, topics);
  Contents contents = play(file, exporting);
  exporting.finish();
  return contents;
}

}  // namespace c3rt::cli
