#pragma once
// The few words of gnuplot that every picture shares.
#include <filesystem>
#include <string>

namespace c3rt::cli::gnuplot {

/// Text inside gnuplot's double quotes.
std::string quoted(const std::string& text);

/// A PNG file of this many pixels, in the house's look.
std::string terminal(const std::filesystem::path& file, int width, int height);

/// Runs one script. @return false if gnuplot is missing or refuses it
bool draw(const std::string& script);

/// What to say of pictures that draw() refused; empty if there is none.
std::string missing(const std::string& pictures);

}  // namespace c3rt::cli::gnuplot
