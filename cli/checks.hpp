#pragma once
// What an option accepts, said in plain words: "expected a number from 0 to 1, got nan".
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace c3rt::cli {

/// A whole number from min to max.
CLI::Validator whole(long long min, long long max);
/// The same, or this word.
CLI::Validator whole_or(long long min, long long max, const std::string& word);
/// A finite number from min to max.
CLI::Validator number(double min, double max);
/// The same; or this word, of which the option gets the value, and the value itself.
CLI::Validator number_or(double min, double max, const std::string& word, double of_word);
/// A length of time: 90, 90s, 15m, 24h or 2d; the option gets it in seconds.
CLI::Validator duration(double min_s, double max_s);
/// One of these words; the error suggests the nearest.
CLI::Validator one_of(std::vector<std::string> words);

/// The same, or what has a comma in it, which is looked at where it is read.
CLI::Validator one_of_or_list(std::vector<std::string> words);

/// --set, any number of times: keys of a scenario in place of those of its file. @param of whose
CLI::Option* add_overrides(CLI::App& command, std::vector<std::string>& given,
                           const std::string& of = "the scenario");

/// The word that a mistyped one most likely means; "" if none is near.
std::string nearest(const std::string& word, const std::vector<std::string>& words);

/// What is wrong with the command line, in one sentence that names the command.
std::string complaint(const CLI::App& app, const CLI::ParseError& error);

}  // namespace c3rt::cli
