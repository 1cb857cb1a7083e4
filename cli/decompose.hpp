#pragma once
// Convex pieces of a mesh by CoACD, a program that may be there or not.
#include <vector>

#include "cli/mesh/mesh.hpp"

namespace c3rt::cli {

/// What a person does to have it.
constexpr const char* kDecomposerInstalled = "pip install coacd trimesh";

/// Runs `coacd -i IN.obj -o OUT.obj` as it is found in PATH.
/// @param mesh one closed surface  @param most pieces
/// @throws UsageError where it is not there, fails or makes no meshes
std::vector<mesh::Triangles> decompose(const mesh::Triangles& mesh, int most);

}  // namespace c3rt::cli
