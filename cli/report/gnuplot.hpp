#pragma once
// The few words of gnuplot that every picture shares.
#include <filesystem>
#include <string>

namespace c3rt::cli::gnuplot {

/// Text inside gnuplot's double quotes.
std::string quoted(const std::string& text);

/// A PNG picture of this many pixels, in the house's look; draw() says which file it goes to.
std::string terminal(int width, int height);

/// Draws one picture by gnuplot; the file comes to be whole or not at all. After gnuplot was found
/// missing or hanging it is not tried again: a run of many pictures waits once.
/// @return why there is no picture; empty if there is
std::string draw(const std::filesystem::path& file, const std::string& script);

/// What to say of pictures that draw() refused; empty if there is none.
std::string missing(const std::string& pictures, const std::string& reason);

}  // namespace c3rt::cli::gnuplot
