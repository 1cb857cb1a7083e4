// LCS of models: from MuJoCo's files, and of the systems that have a name.
#include <algorithm>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <nanobind/nanobind.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include "cli/inspect_lcs.hpp"
#include "cli/paths.hpp"
#include "controller/mjcf/object.hpp"
#include "controller/model/contact_model.hpp"
#include "controller/model/registry.hpp"
#include "controller/scene/scene.hpp"
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

using Files = std::variant<std::filesystem::path, std::vector<std::filesystem::path>>;

std::vector<std::string> files_of(const Files& files) {
  if (const auto* one = std::get_if<std::filesystem::path>(&files)) return {one->string()};
  std::vector<std::string> names;
  for (const auto& each : std::get<1>(files)) names.push_back(each.string());
  return names;
}

/// One file for all bodies or one for each.
std::vector<scene::Object> objects_of(const std::vector<std::string>& files, int bodies,
                                      const std::string& key) {
  const int count = static_cast<int>(files.size());
  if (count != 1 && count != bodies)
    throw std::invalid_argument(key + ": expected one file, or one for each of " +
                                std::to_string(bodies) + " bodies, got " + std::to_string(count));
  std::vector<scene::Object> objects;
  for (int i = 0; i < bodies; ++i)
    objects.push_back(
        mjcf::read_object(files[count == 1 ? 0 : static_cast<std::size_t>(i)]).object);
  return objects;
}

Seen lcs_from_mjcf(const Files& path, std::vector<std::string> pairs, double step,
                   std::string contact_model, nb::handle effector, int support_points,
                   std::optional<int> directions, nb::handle across) {
  cli::InspectSettings settings;
  settings.models = files_of(path);
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

/// What keys say of a model. @param bodies for the key that names objects
model::ModelValues values_of(const std::vector<model::ModelKey>& keys, const nb::kwargs& given,
                             int bodies) {
  std::string known;
  for (const model::ModelKey& key : keys) known += (known.empty() ? "" : ", ") + key.name;
  for (const auto [key, value] : given) {
    const auto name = nb::cast<std::string>(key);
    if (std::none_of(keys.begin(), keys.end(), [&](const auto& of) { return of.name == name; }))
      throw std::invalid_argument(name + ": unknown key, expected one of " + known);
  }
  model::ModelValues values;
  for (const model::ModelKey& key : keys) {
    const auto fail = [&](const std::string& expected, const std::string& got) {
      throw std::invalid_argument(key.name + ": expected " + expected + ", got " + got);
    };
    if (!given.contains(key.name.c_str())) {
      if (!key.missing) fail(key.names_objects ? "a file or one for each body" : "a value", "none");
      values.set(key.name, *key.missing);
      continue;
    }
    const nb::object value = given[key.name.c_str()];
    const std::string got = nb::repr(value).c_str();
    double number = 0.0;
    std::string word;
    if (key.names_objects) {
      Files files;
      if (!nb::try_cast(value, files)) fail("a file or one for each body", got);
      values.set_objects(objects_of(files_of(files), bodies, key.name));
    } else if (!key.choices.empty()) {
      const auto found = nb::try_cast(value, word)
                             ? std::find(key.choices.begin(), key.choices.end(), word)
                             : key.choices.end();
      std::string choices;
      for (const std::string& choice : key.choices)
        choices += (choices.empty() ? "" : ", ") + choice;
      if (found == key.choices.end()) fail("one of " + choices, got);
      values.set(key.name, static_cast<double>(found - key.choices.begin()));
    } else if (!nb::try_cast(value, number) || !(number >= key.min && number <= key.max)) {
      fail("a number in [" + std::to_string(key.min) + ", " + std::to_string(key.max) + "]", got);
    } else {
      values.set(key.name, number);
    }
  }
  return values;
}

NamedSystem make_system(const std::string& name, const nb::kwargs& given) {
  const model::SystemKind& kind = system_kind(name);
  return {kind.make(values_of(kind.keys, given, 0))};
}

/// A planning model by name, for a scene of so many bodies.
struct NamedModel {
  std::shared_ptr<const model::PlanningModel> model;
  int bodies;
};

NamedModel make_model(const std::string& name, int bodies, const nb::kwargs& given) {
  const model::ModelKind& kind = model::model_kind(name);
  if (bodies < kind.min_bodies || bodies > kind.max_bodies)
    throw std::invalid_argument("bodies: expected " + std::to_string(kind.min_bodies) + " to " +
                                std::to_string(kind.max_bodies) + " of " + name + ", got " +
                                std::to_string(bodies));
  return {kind.make(values_of(kind.keys, given, bodies), bodies), bodies};
}

/// Rows for the bodies; where none are given, those that stand there already.
void set_rows(nb::handle of, const char* name, int bodies, int columns,
              const std::function<void(int, const Eigen::VectorXd&)>& set) {
  if (of.is_none()) return;
  const Eigen::MatrixXd rows = matrix(of, name, bodies, columns);
  for (int i = 0; i < bodies; ++i) set(i, rows.row(i));
}

scene::Scene scene_of(const NamedModel& of, nb::handle effector, nb::handle positions,
                      nb::handle orientations, nb::handle effector_velocity, nb::handle velocities,
                      nb::handle rates) {
  scene::Scene scene = of.model->layout().world;
  scene.effector.p_WE = vector(effector, "effector", 3);
  if (!effector_velocity.is_none())
    scene.effector.v_WE = vector(effector_velocity, "effector_velocity", 3);
  set_rows(positions, "positions", of.bodies, 3,
           [&](int i, const Eigen::VectorXd& row) { scene.body(i).p_WB = row; });
  set_rows(velocities, "velocities", of.bodies, 3,
           [&](int i, const Eigen::VectorXd& row) { scene.body(i).v_WB = row; });
  set_rows(rates, "rates", of.bodies, 3,
           [&](int i, const Eigen::VectorXd& row) { scene.body(i).omega_WB = row; });
  set_rows(orientations, "orientations", of.bodies, 4, [&](int i, const Eigen::VectorXd& row) {
    if (!(row.norm() > 0.0))
      throw std::invalid_argument("orientations: expected a quaternion w x y z, got zeros");
    const Eigen::Vector4d unit = row.normalized();
    scene.body(i).q_WB = Eigen::Quaterniond(unit[0], unit[1], unit[2], unit[3]);
  });
  return scene;
}

std::vector<int> contacts_of(const NamedModel& of, const std::vector<std::string>& pairs) {
  const std::vector<model::ModelContact>& all = of.model->layout().contacts;
  if (pairs.empty()) return model::all_contacts(of.model->layout());
  std::vector<int> chosen;
  for (const std::string& pair : pairs) {
    if (std::none_of(all.begin(), all.end(), [&](const auto& one) { return one.pair == pair; }))
      throw std::invalid_argument("pairs: expected pairs that the model has, got \"" + pair + "\"");
  }
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (std::find(pairs.begin(), pairs.end(), all[i].pair) != pairs.end())
      chosen.push_back(static_cast<int>(i));
  }
  return chosen;
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

  module.def(
      "planning_models",
      [] {
        std::vector<std::string> all;
        for (const model::ModelKind& kind : model::model_kinds()) all.push_back(kind.name);
        return all;
      },
      "The names of the planning models.");
  nb::class_<NamedModel>(
      module, "PlanningModel",
      "A planning model by its name, of an end effector and bodies on a table, with the keys that "
      "a "
      "scenario has of it. Frames: the world's; centres of mass, quaternions w x y z.")
      .def(
          "__init__",
          [](NamedModel* self, const std::string& name, int bodies, const nb::kwargs& keys) {
            new (self) NamedModel(make_model(name, bodies, keys));
          },
          "name"_a, "bodies"_a = 1, "keys"_a,
          nb::sig("def __init__(self, name: str, bodies: int = 1, **keys: typing.Any) -> None"))
      .def_static(
          "keys",
          [](const std::string& name) {
            std::vector<std::string> all;
            for (const model::ModelKey& key : model::model_kind(name).keys) all.push_back(key.name);
            return all;
          },
          "name"_a, "Which keys it has.")
      .def_prop_ro(
          "pairs",
          [](const NamedModel& self) {
            std::vector<std::string> all;
            for (const model::ModelContact& contact : self.model->layout().contacts) {
              if (std::find(all.begin(), all.end(), contact.pair) == all.end())
                all.push_back(contact.pair);
            }
            return all;
          },
          "Which may touch, by name.")
      .def(
          "state",
          [](const NamedModel& self, nb::handle effector, nb::handle positions,
             nb::handle orientations, nb::handle effector_velocity, nb::handle velocities,
             nb::handle rates) {
            Eigen::VectorXd x(self.model->layout().n_x);
            self.model->state(scene_of(self, effector, positions, orientations, effector_velocity,
                                       velocities, rates),
                              x);
            return copy(x);
          },
          "effector"_a, "positions"_a, "orientations"_a = nb::none(),
          "effector_velocity"_a = nb::none(), "velocities"_a = nb::none(), "rates"_a = nb::none(),
          nb::sig("def state(self, effector: numpy.typing.ArrayLike, positions: "
                  "numpy.typing.ArrayLike, orientations: numpy.typing.ArrayLike | None = None, "
                  "effector_velocity: numpy.typing.ArrayLike | None = None, velocities: "
                  "numpy.typing.ArrayLike | None = None, rates: numpy.typing.ArrayLike | None = "
                  "None) -> numpy.typing.NDArray"),
          "x of a scene: effector (3,), positions (bodies, 3), orientations (bodies, 4), "
          "velocities "
          "and rates (bodies, 3); upright and at rest where they are not given.")
      .def(
          "lcs",
          [](const NamedModel& self, nb::handle effector, nb::handle positions, double step,
             nb::handle orientations, nb::handle effector_velocity, nb::handle velocities,
             nb::handle rates, const std::vector<std::string>& pairs,
             const std::string& contact_model) {
            if (!(step > 0.0))
              throw std::invalid_argument("step: expected a positive number, got " +
                                          std::to_string(step));
            if (contact_model != "anitescu" && contact_model != "stewart_trinkle")
              throw std::invalid_argument(
                  "contact_model: expected anitescu or stewart_trinkle, got \"" + contact_model +
                  "\"");
            const model::ContactSystem system =
                self.model->contact_system(scene_of(self, effector, positions, orientations,
                                                    effector_velocity, velocities, rates),
                                           contacts_of(self, pairs));
            return model::to_lcs(contact_model == "anitescu" ? model::ContactModel::kAnitescu
                                                             : model::ContactModel::kStewartTrinkle,
                                 system, step);
          },
          "effector"_a, "positions"_a, "step"_a, "orientations"_a = nb::none(),
          "effector_velocity"_a = nb::none(), "velocities"_a = nb::none(), "rates"_a = nb::none(),
          "pairs"_a = std::vector<std::string>(), "contact_model"_a = "anitescu",
          nb::sig("def lcs(self, effector: numpy.typing.ArrayLike, positions: "
                  "numpy.typing.ArrayLike, step: float, orientations: numpy.typing.ArrayLike | "
                  "None = None, effector_velocity: numpy.typing.ArrayLike | None = None, "
                  "velocities: numpy.typing.ArrayLike | None = None, rates: "
                  "numpy.typing.ArrayLike | None = None, pairs: collections.abc.Sequence[str] = "
                  "(), contact_model: str = 'anitescu') -> LCS"),
          "The LCS about a scene, with the contacts of these pairs, or of all; step in seconds.");
}

}  // namespace c3rt::python
