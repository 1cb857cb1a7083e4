#include "cli/recording/recording.hpp"

#include <memory>
#include <string_view>

#include "idl/idl_text.hpp"
#include "idl/validate.hpp"

namespace c3rt::cli {
namespace {

constexpr const char* kMessageEncoding = "cdr";
constexpr const char* kSchemaEncoding = "omgidl";

/// "c3rt::v2::RobotState"
std::string type_name(const wire::Topic& topic) { return topic.descriptor->m_typename; }

/// How a sample of a channel is heard.
using Hear = bool (*)(const mcap::Message& message, Listener& listener);

template <typename T>
bool hear(const mcap::Message& message, Listener& listener) {
  T sample;
  if (!wire::from_cdr(message.data, message.size, sample) || wire::validate(sample)) return false;
  listener.hear(sample);
  return true;
}

class Playing final : public mcap::Listener {
 public:
  Playing(cli::Listener& listener, Contents& contents) : listener_(listener), contents_(contents) {}

  void hear(const mcap::Schema& schema) override { schemas_[schema.id] = schema; }

  void hear(const mcap::Channel& channel) override {
    Heard heard;
    heard.topic = channel.topic;
    const mcap::Schema& schema = schemas_[channel.schema];
    bool known = false;
    wire::with_topic(channel.topic, [&](const auto& sample) {
      using T = std::decay_t<decltype(sample)>;
      known = true;
      if (schema.name == type_name(wire::topic<T>()) && channel.encoding == kMessageEncoding)
        heard.hear = &cli::hear<T>;
    });
    if (heard.hear == nullptr) {
      contents_.other[channel.topic] =
          known ? schema.name + " in " + channel.encoding : "no topic of this contract";
    }
    channels_[channel.id] = heard;
  }

  void hear(const mcap::Message& message) override {
    const Heard& heard = channels_[message.channel];
    if (heard.hear == nullptr) return;
    ++(heard.hear(message, listener_) ? contents_.samples : contents_.refused)[heard.topic];
  }

  void hear(const mcap::Attachment& attachment) override {
    contents_.attachments[attachment.name] = attachment.data;
  }

  void hear(const std::string& name, const mcap::Texts& metadata) override {
    contents_.metadata[name] = metadata;
  }

  bool has_enough() const override { return listener_.has_enough(); }

 private:
  struct Heard {
    std::string topic;
    Hear hear = nullptr;
  };
  cli::Listener& listener_;
  Contents& contents_;
  std::map<std::uint16_t, mcap::Schema> schemas_;
  std::map<std::uint16_t, Heard> channels_;
};

}  // namespace

Recording::Recording(const std::filesystem::path& file) : writer_(file, "", "c3rt") {
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    const wire::Topic& topic = wire::table::kTopics[i];
    if (!is_recorded(topic)) continue;
    const std::uint16_t schema =
        writer_.add_schema(type_name(topic), kSchemaEncoding, wire::idl_text());
    channels_[i] = writer_.add_channel(schema, topic.name, kMessageEncoding);
  }
}

void Recording::write(int place, const wire::Header& header) {
  writer_.write({channels_[static_cast<std::size_t>(place)], static_cast<std::uint32_t>(header.seq),
                 header.time_ns, header.time_ns, bytes_.data(), bytes_.size()});
}

void Recording::attach(const std::string& name, const std::string& media_type,
                       const std::string& data) {
  writer_.attach({name, media_type, data});
}

void Recording::add_metadata(const std::string& name, const mcap::Texts& texts) {
  writer_.add_metadata(name, texts);
}

void Recording::finish() { writer_.finish(); }

Contents play(const std::filesystem::path& file, Listener& listener) {
  Contents contents;
  Playing playing(listener, contents);
  contents.ending = mcap::read(file, playing);
  return contents;
}

Contents play_bytes(std::string_view bytes, Listener& listener) {
  Contents contents;
  Playing playing(listener, contents);
  contents.ending = mcap::read_bytes(bytes, playing);
  return contents;
}

}  // namespace c3rt::cli
