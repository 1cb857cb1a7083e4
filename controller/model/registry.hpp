#pragma once
// The models by name: a new one is a file of its own and one line in registry.cpp.
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "controller/model/between.hpp"
#include "controller/model/planning_model.hpp"
#include "controller/model/system_model.hpp"
#include "controller/scene/mechanism.hpp"
#include "controller/scene/object.hpp"

namespace c3rt::model {

/// One thing that a model is made from, as a scenario names it, and what it may be: a number, one
/// of several words, or files.
struct ModelKey {
  std::string name;
  double min = 0.0, max = 0.0;
  std::vector<std::string> choices = {};  // where it names one of these: its value is the index
  std::optional<double> missing = {};     // its value where a scenario does not name it
  bool names_objects = false;             // MJCF files, one for all bodies or one for each
  bool names_mechanism = false;           // the MJCF file of all, and which contacts it has
};

/// What a scenario says, by keys.
class ModelValues {
 public:
  void set(const std::string& key, double value) { values_[key] = value; }
  void set_objects(std::vector<scene::Object> objects) { objects_ = std::move(objects); }
  /// @throws std::out_of_range naming a key that is not there
  double operator[](const std::string& key) const;
  void set_mechanism(std::shared_ptr<scene::Mechanism> mechanism, std::vector<Between> contacts) {
    mechanism_ = std::move(mechanism);
    contacts_ = std::move(contacts);
  }
  /// Of the key that names them, one for each body.
  const std::vector<scene::Object>& objects() const noexcept { return objects_; }
  /// Of the key that names it; null without one.
  const std::shared_ptr<scene::Mechanism>& mechanism() const noexcept { return mechanism_; }
  const std::vector<Between>& contacts() const noexcept { return contacts_; }

 private:
  std::map<std::string, double> values_;
  std::vector<scene::Object> objects_;
  std::shared_ptr<scene::Mechanism> mechanism_;
  std::vector<Between> contacts_;
};

struct ModelKind {
  std::string name;
  int min_bodies, max_bodies;  // of a scene that it can be of
  std::vector<ModelKey> keys;
  std::unique_ptr<PlanningModel> (*make)(const ModelValues& values, int bodies);
  // the keys of a body's mass and size, by which weights and lengths carry over to another body;
  // none: they do not
  std::string mass_key, size_key;
};

const std::vector<ModelKind>& model_kinds();

/// @throws std::invalid_argument naming the kinds that there are
const ModelKind& model_kind(const std::string& name);

/// A model that stands for itself, without a scene.
struct SystemKind {
  std::string name;
  std::vector<ModelKey> keys;
  std::shared_ptr<const SystemModel> (*make)(const ModelValues& values);
};

const std::vector<SystemKind>& system_kinds();

/// The kind for so many bodies where a scenario names none.
const ModelKind& default_model_kind(int bodies);

}  // namespace c3rt::model
