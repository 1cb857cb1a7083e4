// LCS of models: from MuJoCo's files, and of the systems that have a name.
#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include "cli/inspect_lcs.hpp"
#include "cli/paths.hpp"
#include "controller/model/registry.hpp"
#include "python/src/arrays.hpp"
#include "python/src/bind.hpp"
#include "python/src/problem.hpp"

namespace c3rt::python {
namespace {

using cli::Seen;
using namespace nb::literals;

/// Of a command line's words those of a call: "--pairs: expected …" is "pairs: expected …".
[[noreturn]] void throw_as_value(const cli::UsageError& error) {
  std::string text = error.what();
  if (text.rfind("--", 0) == 0) {
    text = text.substr(2);
    std::replace(text.begin(), std::find(text.begin(), text.end(), ':'), '-', '_');
  }
  throw std::invalid_argument(text);
}

Seen lcs_from_mjcf(
    const std::variant<std::filesystem::path, std::vector<std::filesystem::path>>& path,
    std::vector<std::string> pairs, double step, std::string contact_model, nb::handle effector,
    int support_points, std::optional<int> directions, nb::handle across) {
  cli::InspectSettings settings;
  if (const auto* each = std::get_if<std::vector<std::filesystem::path>>(&path)) {
    for (const auto& one : *each) settings.models.push_back(one.string());
  } else {
    settings.models.push_back(std::get<std::filesystem::path>(path).string());
  }
  if (settings.models.empty())
    throw std::invalid_argument("path: expected a file or several, got none");
  if (!(step > 0.0 && step <= 1.0))
    throw std::invalid_argument("step: expected a number in (0, 1], got " + std::to_string(step));
  const auto point = [](nb::handle of, const char* name) {
    if (of.is_none()) return std::vector<double>();
    const Eigen::VectorXd values = vector(of, name, 3);
    return std::vector<double>(values.begin(), values.end());
  };
  settings.pairs = std::move(pairs);
  settings.step = step;
  settings.contact_model = std::move(contact_model);
  settings.effector = point(effector, "effector");
  settings.support_points = support_points;
  settings.directions = directions;
  settings.across = point(across, "across");
  try {
    const nb::gil_scoped_release others_run;
    if (cli::has_motors(settings)) return cli::see_mechanism(settings);
    return cli::see_objects(settings);
  } catch (const cli::UsageError& error) {
    throw_as_value(error);
  }
}

template <auto Member>
Array entry(nb::handle_t<Seen> self) {
  return view(nb::cast<const Seen&>(self).*Member, self);
}

/// A model by name, whose LCS is known about each state.
using System = std::shared_ptr<const model::SystemModel>;
struct NamedSystem {
  System model;
};

const model::SystemKind& system_kind(const std::string& name) {
  std::string known;
  for (const model::SystemKind& kind : model::system_kinds()) {
    const bool of_files = std::any_of(kind.keys.begin(), kind.keys.end(),
                                      [](const auto& key) { return key.names_mechanism; });
    if (of_files) continue;  // lcs_from_mjcf
    if (kind.name == name) return kind;
    known += (known.empty() ? "" : ", ") + kind.name;
  }
  throw std::invalid_argument("name: expected one of " + known + ", got \"" + name + "\"");
}

NamedSystem make_system(const std::string& name, const nb::kwargs& given) {
  const model::SystemKind& kind = system_kind(name);
  std::string known;
  for (const model::ModelKey& key : kind.keys) known += (known.empty() ? "" : ", ") + key.name;
  for (const auto [key, value] : given) {
    const auto name_of = nb::cast<std::string>(key);
    if (std::none_of(kind.keys.begin(), kind.keys.end(),
                     [&](const auto& of) { return of.name == name_of; }))
      throw std::invalid_argument(name_of + ": unknown key, expected one of " + known);
  }
  model::ModelValues values;
  for (const model::ModelKey& key : kind.keys) {
    if (!given.contains(key.name.c_str())) {
      if (!key.missing) throw std::invalid_argument(key.name + ": expected a number, got none");
      values.set(key.name, *key.missing);
      continue;
    }
    const nb::object value = given[key.name.c_str()];
    double number = 0.0;
    if (!nb::try_cast(value, number) || !(number >= key.min && number <= key.max))
      throw std::invalid_argument(key.name + ": expected a number in [" + std::to_string(key.min) +
                                  ", " + std::to_string(key.max) + "], got " +
                                  nb::repr(value).c_str());
    values.set(key.name, number);
  }
  return {kind.make(values)};
}

std::vector<std::string> names(const std::vector<model::Quantity>& of) {
  std::vector<std::string> all;
  for (const model::Quantity& quantity : of) all.push_back(quantity.name);
  return all;
}

}  // namespace

void bind_models(nb::module_& module) {
  nb::class_<Seen>(module, "MjcfLcs", "What a planner sees of a MuJoCo model where it lies.")
      .def_prop_ro("lcs", [](const Seen& self) { return self.lcs; })
      .def_prop_ro("x0", entry<&Seen::x0>, "(n_x,), where the file puts it")
      .def_prop_ro(
          "names", [](const Seen& self) { return self.names; },
          "Of each entry of x; \"\" where it has none.")
      .def_prop_ro("xd", entry<&Seen::x_desired>,
                   "(n_x,), the target of problem(): objects 0.1 m along x, else a joint")
      .def_prop_ro("u_min", entry<&Seen::u_min>, "(n_u,), of the motors")
      .def_prop_ro("u_max", entry<&Seen::u_max>, "(n_u,)")
      .def(
          "problem",
          [](const Seen& self) { return parse_problem(cli::problem_file(self), "problem"); },
          "The problem that c3rt lcs inspect --out writes: by C3+, to xd.");
  module.def(
      "lcs_from_mjcf", &lcs_from_mjcf, "path"_a, "pairs"_a = std::vector<std::string>(),
      "step"_a = 0.05, "contact_model"_a = "anitescu", "effector"_a = nb::none(),
      "support_points"_a = 4, "directions"_a = nb::none(), "across"_a = nb::none(),
      nb::sig("def lcs_from_mjcf(path: str | os.PathLike[str] | "
              "collections.abc.Sequence[str | os.PathLike[str]], pairs: "
              "collections.abc.Sequence[str] = (), step: float = 0.05, contact_model: str = "
              "'anitescu', effector: numpy.typing.ArrayLike | None = None, support_points: int = "
              "4, directions: int | None = None, across: numpy.typing.ArrayLike | None = None) -> "
              "MjcfLcs"),
      "As c3rt lcs inspect sees it, whose options these are (docs/objects.md): rigid objects on a "
      "table, one a file, which an end effector pushes; or a mechanism with motors, from one file. "
      "ValueError names the file, or the argument, and what was expected.");

  module.def(
      "systems",
      [] {
        std::vector<std::string> all;
        for (const model::SystemKind& kind : model::system_kinds()) {
          if (std::none_of(kind.keys.begin(), kind.keys.end(),
                           [](const auto& key) { return key.names_mechanism; }))
            all.push_back(kind.name);
        }
        return all;
      },
      "The names of the systems.");
  nb::class_<NamedSystem>(module, "System",
                          "A model by its name, with the keys that a scenario has of it.")
      .def(
          "__init__",
          [](NamedSystem* self, const std::string& name, const nb::kwargs& keys) {
            new (self) NamedSystem(make_system(name, keys));
          },
          "name"_a, "keys"_a, nb::sig("def __init__(self, name: str, **keys: float) -> None"))
      .def_static(
          "keys",
          [](const std::string& name) {
            std::vector<std::string> all;
            for (const model::ModelKey& key : system_kind(name).keys) all.push_back(key.name);
            return all;
          },
          "name"_a, "Which keys it has.")
      .def(
          "lcs",
          [](const NamedSystem& self, nb::handle x, double step) {
            if (!(step > 0.0))
              throw std::invalid_argument("step: expected a positive number, got " +
                                          std::to_string(step));
            return self.model->planning_system(vector(x, "x", self.model->layout().n_x()), step);
          },
          "x"_a, "step"_a, nb::sig("def lcs(self, x: numpy.typing.ArrayLike, step: float) -> LCS"),
          "The LCS about a state, to plan with; step in seconds.")
      .def_prop_ro("x_names", [](const NamedSystem& self) { return names(self.model->layout().x); })
      .def_prop_ro("u_names", [](const NamedSystem& self) { return names(self.model->layout().u); })
      .def_prop_ro("lam_names",
                   [](const NamedSystem& self) { return names(self.model->layout().lambda); });
}

}  // namespace c3rt::python
