#pragma once
// Programs in Python beside this one, which take other people's packages into use.
#include <filesystem>
#include <string>

namespace c3rt::cli::campaign {

/// A Python that can import a module: C3RT_PYTHON, that of the PATH, or Debian's.
/// @param wanted by whom, for the message: "--engine dask" @param package of pip, python3-PACKAGE
/// of Debian
/// @throws UsageError naming which were looked at
std::string python_with(const std::string& wanted, const std::string& module,
                        const std::string& package);

/// One of our own, in the sources (cli/FOLDER) or where it is installed. @throws UsageError
std::filesystem::path python_file(const std::string& folder, const std::string& name);

}  // namespace c3rt::cli::campaign
