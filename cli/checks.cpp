#include "cli/checks.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "config/text.hpp"

namespace c3rt::cli {
namespace {

template <typename T>
bool parse(const std::string& text, T& value) {
  const char* begin = text.data() + (text.size() > 1 && text[0] == '+' ? 1 : 0);
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(begin, end, value);
  return error == std::errc() && rest == end;
}

std::string got(const std::string& input) { return ", got \"" + config::printable(input) + "\""; }

/// Number of letters to change, add or remove (Levenshtein).
std::size_t distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t changed = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, changed});
    }
  }
  return row[b.size()];
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::string suggestion(const std::string& word, const std::vector<std::string>& words) {
  const std::string meant = nearest(word, words);
  return meant.empty() ? "" : "; did you mean \"" + meant + "\"?";
}

/// The command that was being read: "c3rt fault stall".
const CLI::App& innermost(const CLI::App& app, std::string& name) {
  const CLI::App* at = &app;
  name = app.get_name();
  for (auto chosen = at->get_subcommands(); !chosen.empty(); chosen = at->get_subcommands()) {
    at = chosen.back();
    name += " " + at->get_name();
  }
  return *at;
}

std::vector<std::string> commands_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(command->get_name());
  return names;
}

std::vector<std::string> options_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

/// "c3rt fault: "; nothing of c3rt itself, whose name begins every message
std::string before(const std::string& command) {
  return command.find(' ') == std::string::npos ? "" : command + ": ";
}

std::string lacks_command(const CLI::App& app, const std::string& name) {
  const std::vector<std::string> known = commands_of(app), rest = app.remaining();
  const auto word = std::find_if(rest.begin(), rest.end(), [](const std::string& text) {
    return !text.empty() && text[0] != '-';
  });
  if (word == rest.end()) {
    if (!rest.empty()) {
      return fmt::format("{}there is no option \"{}\"{} ({} --help)", before(name),
                         config::printable(rest.front()), suggestion(rest.front(), options_of(app)),
                         name);
    }
    return fmt::format("{}a command is missing, one of: {} ({} --help)", before(name),
                       joined(known), name);
  }
  return fmt::format(
      "{}there is no command \"{}\"{} Known: {}", before(name), config::printable(*word),
      known.empty() || nearest(*word, known).empty() ? "." : suggestion(*word, known),
      joined(known));
}

std::string unexpected(const CLI::App& app, const std::string& name) {
  const std::vector<std::string> rest = app.remaining();
  const std::string word = rest.empty() ? "" : rest.front();
  if (word.size() > 1 && word[0] == '-') {
    return fmt::format("{}there is no option \"{}\"{} ({} --help)", before(name),
                       config::printable(word), suggestion(word, options_of(app)), name);
  }
  return fmt::format("{}\"{}\" is one word too many ({} --help)", before(name),
                     config::printable(word), name);
}

}  // namespace

CLI::Validator whole(long long min, long long max) {
  const std::string expected = fmt::format("a whole number from {} to {}", min, max);
  return CLI::Validator(
      [=](std::string& input) {
        long long value = 0;
        const bool fits = parse(input, value) && value >= min && value <= max;
        return fits ? std::string() : "expected " + expected + got(input);
      },
      fmt::format("{} to {}", min, max));
}

CLI::Validator whole_or(long long min, long long max, const std::string& word) {
  const CLI::Validator is_whole = whole(min, max);
  return CLI::Validator(
      [=](std::string& input) {
        std::string wrong = input == word ? "" : is_whole(input);
        if (!wrong.empty()) wrong.insert(wrong.find(", got"), ", or " + word);
        return wrong;
      },
      fmt::format("{} to {}, {}", min, max, word));
}

CLI::Validator number(double min, double max) {
  const std::string expected = fmt::format("a number from {:g} to {:g}", min, max);
  return CLI::Validator(
      [=](std::string& input) {
        double value = 0.0;
        const bool fits =
            parse(input, value) && std::isfinite(value) && value >= min && value <= max;
        return fits ? std::string() : "expected " + expected + got(input);
      },
      fmt::format("{:g} to {:g}", min, max));
}

CLI::Validator number_or(double min, double max, const std::string& word, double of_word) {
  const CLI::Validator is_number = number(min, max);
  return CLI::Validator(
      [=](std::string& input) {
        double value = 0.0;
        if (input == word) input = fmt::format("{}", of_word);
        if (parse(input, value) && value == of_word) return std::string();
        std::string wrong = is_number(input);
        if (!wrong.empty())
          wrong.insert(wrong.find(", got"), fmt::format(", {:g} or {}", of_word, word));
        return wrong;
      },
      fmt::format("{:g} to {:g}, {}", min, max, word));
}

CLI::Validator duration(double min_s, double max_s) {
  const std::string expected =
      fmt::format("a time from {:g} s to {:g} h, as 90s, 15m, 24h", min_s, max_s / 3600.0);
  return CLI::Validator(
      [=](std::string& input) {
        const std::size_t end = input.find_last_of("0123456789.") + 1;
        const std::string unit = input.substr(end);
        const double factor = unit.empty() || unit == "s"    ? 1.0
                              : unit == "m" || unit == "min" ? 60.0
                              : unit == "h"                  ? 3600.0
                              : unit == "d"                  ? 86400.0
                                                             : 0.0;
        double value = 0.0;
        const bool fits = factor > 0.0 && parse(input.substr(0, end), value) &&
                          std::isfinite(value) && value * factor >= min_s &&
                          value * factor <= max_s;
        if (!fits) return "expected " + expected + got(input);
        input = fmt::format("{}", value * factor);
        return std::string();
      },
      "TIME");
}

CLI::Validator one_of(std::vector<std::string> words) {
  const std::string known = joined(words);
  return CLI::Validator(
      [words = std::move(words), known](std::string& input) {
        if (std::find(words.begin(), words.end(), input) != words.end()) return std::string();
        return "expected one of " + known + got(input) + suggestion(input, words);
      },
      known);
}

CLI::Validator one_of_or_list(std::vector<std::string> words) {
  const std::string known = joined(words);
  const CLI::Validator word = one_of(std::move(words));
  return CLI::Validator(
      [word](std::string& input) {
        return input.find(',') == std::string::npos ? word(input) : std::string();
      },
      known);
}

CLI::Option* add_overrides(CLI::App& command, std::vector<std::string>& given,
                           const std::string& of) {
  return command.add_option("--set", given, "Overrides one key of " + of + ": section.key=value")
      ->expected(1)
      ->take_all();
}

std::string nearest(const std::string& word, const std::vector<std::string>& words) {
  std::string best;
  if (word.size() > 64) return best;
  std::size_t least = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string& candidate : words) {
    // who stops early is understood, too
    const bool begun = word.size() >= 2 && candidate.compare(0, word.size(), word) == 0;
    const std::size_t away = begun ? 1 : distance(word, candidate);
    if (away < least && away < candidate.size()) {
      least = away;
      best = candidate;
    }
  }
  return best;
}

std::string complaint(const CLI::App& app, const CLI::ParseError& error) {
  std::string name;
  const CLI::App& at = innermost(app, name);
  const bool wants_command = at.get_require_subcommand_min() > 0 && at.get_subcommands().empty();
  if (wants_command) return lacks_command(at, name);
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr) return unexpected(at, name);
  return fmt::format("{}{} ({} --help)", before(name), config::printable(error.what(), 2000), name);
}

}  // namespace c3rt::cli
