#pragma once
// Files in the format MCAP (https://mcap.dev/spec), as other tools read them: messages in
// compressed chunks with an index, schemas, attachments, metadata. It knows nothing of what is in
// them.
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace c3rt::mcap {

/// A file cannot be written or read, or what is in it is no MCAP: the text names it and says why.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

using Texts = std::map<std::string, std::string>;

struct Schema {
  std::uint16_t id = 0;  // from 1
  std::string name, encoding, text;
};

struct Channel {
  std::uint16_t id = 0;  // from 1
  std::uint16_t schema = 0;
  std::string topic, encoding;
  Texts metadata;
};

struct Message {
  std::uint16_t channel = 0;
  std::uint32_t sequence = 0;
  std::int64_t log_ns = 0, publish_ns = 0;
  const std::uint8_t* data = nullptr;
  std::size_t size = 0;
};

struct Attachment {
  std::string name, media_type, data;
};

/// Writes one file from its beginning to its end. Each chunk is on the disk when the next begins,
/// so that what a crash leaves can be read up to its last whole chunk. Bounded memory but for the
/// index: some 30 bytes for each channel of a chunk.
class Writer {
 public:
  static constexpr std::size_t kChunk = 1U << 20;       // of messages, before compression [bytes]
  static constexpr std::int64_t kLongest = 1000000000;  // of one, of time [ns]

  /// @param profile of the format; may be empty @param library that writes it
  /// @throws Error if there is such a file already, or it cannot be written
  Writer(const std::filesystem::path& path, const std::string& profile, const std::string& library);
  /// What has not been finished is left as a crash would leave it.
  ~Writer();
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  // All that follows throws Error where the disk has no room, and then again at every call.

  std::uint16_t add_schema(const std::string& name, const std::string& encoding,
                           const std::string& text);
  std::uint16_t add_channel(std::uint16_t schema, const std::string& topic,
                            const std::string& encoding, const Texts& metadata = {});
  void write(const Message& message);
  void attach(const Attachment& attachment);
  void add_metadata(const std::string& name, const Texts& texts);
  /// The index and the end.
  void finish();

  std::uint64_t messages() const;
  std::uint64_t bytes() const;  // of the file, so far

 private:
  struct State;
  void end_chunk();
  std::unique_ptr<State> state_;
};

/// Hears what is in a file, in its order.
class Listener {
 public:
  virtual ~Listener() = default;
  virtual void hear(const Schema&) {}
  virtual void hear(const Channel&) {}  // its schema came before it
  virtual void hear(const Message&) {}  // its channel came before it
  virtual void hear(const Attachment&) {}
  virtual void hear(const std::string& /*name*/, const Texts& /*metadata*/) {}
  /// Asked after each record: the rest is not read.
  virtual bool has_enough() const { return false; }
};

/// How a file ended.
struct Ending {
  bool whole = false;  // to its last record
  std::string why;     // not
};

/// Reads a file to its end, to where it is cut off or damaged, or until its listener has enough:
/// all before that is heard. It needs no index. @throws Error if it cannot be opened or does not
/// begin as an MCAP
Ending read(const std::filesystem::path& path, Listener& listener);
/// The same of bytes.
Ending read_bytes(std::string_view bytes, Listener& listener);

}  // namespace c3rt::mcap
