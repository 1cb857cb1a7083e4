#include "cli/recording/mcap.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>
#include <set>

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>
#include <zlib.h>
#include <zstd.h>

namespace c3rt::mcap {
namespace {

constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
constexpr int kCompression = 1;                     // zstd's fastest but for the negative ones
constexpr std::uint64_t kLargestRecord = 1U << 30;  // that is read [bytes]

enum Opcode : std::uint8_t {
  kHeader = 1,
  kFooter,
  kSchema,
  kChannel,
  kMessage,
  kChunkRecord,
  kMessageIndex,
  kChunkIndex,
  kAttachment,
  kAttachmentIndex,
  kStatistics,
  kMetadata,
  kMetadataIndex,
  kSummaryOffset,
  kDataEnd,
};

std::uint32_t crc_of(std::string_view bytes, std::uint32_t before = 0) {
  return static_cast<std::uint32_t>(
      crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

/// The content of a record, as it is put together.
class Content {
 public:
  template <typename T>
  Content& number(T value) {
    static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "as in the file");
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  Content& time(std::int64_t ns) { return number(static_cast<std::uint64_t>(ns)); }
  Content& text(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size()));
    return raw(text);
  }
  Content& raw(std::string_view bytes) {
    bytes_.append(bytes);
    return *this;
  }
  Content& texts(const Texts& texts) {
    Content pairs;
    for (const auto& [key, value] : texts) pairs.text(key).text(value);
    return text(pairs.bytes());
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

void append_record(std::string& to, Opcode opcode, std::string_view content) {
  const std::uint64_t size = content.size();
  to.push_back(static_cast<char>(opcode));
  to.append(reinterpret_cast<const char*>(&size), sizeof size);
  to.append(content);
}

std::string content_of(const Schema& schema) {
  return Content()
      .number(schema.id)
      .text(schema.name)
      .text(schema.encoding)
      .text(schema.text)
      .bytes();
}

std::string content_of(const Channel& channel) {
  return Content()
      .number(channel.id)
      .number(channel.schema)
      .text(channel.topic)
      .text(channel.encoding)
      .texts(channel.metadata)
      .bytes();
}

/// The earliest and the latest.
struct Span {
  std::int64_t first = std::numeric_limits<std::int64_t>::max();
  std::int64_t last = std::numeric_limits<std::int64_t>::min();
  bool any() const { return first <= last; }
  void add(std::int64_t ns) {
    first = std::min(first, ns);
    last = std::max(last, ns);
  }
  std::int64_t begin() const { return any() ? first : 0; }
  std::int64_t end() const { return any() ? last : 0; }
};

}  // namespace

struct Writer::State {
  std::filesystem::path path;
  int file = -1;
  bool failed = false;
  std::uint64_t at = 0;  // bytes written

  std::vector<Schema> schemas;
  std::vector<Channel> channels;
  std::map<std::uint16_t, std::uint64_t> counts;  // messages by channel
  std::uint64_t messages = 0;
  Span all;

  // of the chunk
  std::string records, compressed;
  Span span;
  std::map<std::uint16_t, std::vector<std::pair<std::int64_t, std::uint64_t>>> index;
  std::vector<std::string> chunk_indices, attachment_indices, metadata_indices;

  ~State() {
    if (file >= 0) close(file);
  }

  [[noreturn]] void fail(int error) {
    failed = true;
    throw Error("cannot write " + path.string() + ": " + std::strerror(error));
  }

  void put(std::string_view bytes) {
    if (failed) throw Error("cannot write " + path.string() + ": an earlier write failed");
    while (!bytes.empty()) {
      const ssize_t written = ::write(file, bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) fail(errno);
      bytes.remove_prefix(static_cast<std::size_t>(written));
      at += static_cast<std::uint64_t>(written);
    }
  }

  void put_record(Opcode opcode, std::string_view content) {
    std::string record;
    append_record(record, opcode, content);
    put(record);
  }
};

Writer::Writer(const std::filesystem::path& path, const std::string& profile,
               const std::string& library)
    : state_(std::make_unique<State>()) {
  state_->path = path;
  state_->file = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (state_->file < 0) state_->fail(errno);
  state_->put(kMagic);
  state_->put_record(kHeader, Content().text(profile).text(library).bytes());
}

Writer::~Writer() = default;

std::uint16_t Writer::add_schema(const std::string& name, const std::string& encoding,
                                 const std::string& text) {
  State& s = *state_;
  s.schemas.push_back({static_cast<std::uint16_t>(s.schemas.size() + 1), name, encoding, text});
  append_record(s.records, kSchema, content_of(s.schemas.back()));
  return s.schemas.back().id;
}

std::uint16_t Writer::add_channel(std::uint16_t schema, const std::string& topic,
                                  const std::string& encoding, const Texts& metadata) {
  State& s = *state_;
  s.channels.push_back(
      {static_cast<std::uint16_t>(s.channels.size() + 1), schema, topic, encoding, metadata});
  append_record(s.records, kChannel, content_of(s.channels.back()));
  return s.channels.back().id;
}

void Writer::write(const Message& message) {
  State& s = *state_;
  if (s.failed) s.put({});
  if (s.span.any() && message.log_ns - s.span.first > kLongest) end_chunk();
  s.index[message.channel].emplace_back(message.log_ns, s.records.size());
  const std::string head = Content()
                               .number(message.channel)
                               .number(message.sequence)
                               .time(message.log_ns)
                               .time(message.publish_ns)
                               .bytes();
  const std::uint64_t size = head.size() + message.size;
  s.records.push_back(static_cast<char>(kMessage));
  s.records.append(reinterpret_cast<const char*>(&size), sizeof size);
  s.records.append(head);
  s.records.append(reinterpret_cast<const char*>(message.data), message.size);
  s.span.add(message.log_ns);
  s.all.add(message.log_ns);
  ++s.counts[message.channel];
  ++s.messages;
  if (s.records.size() >= kChunk) end_chunk();
}

void Writer::end_chunk() {
  State& s = *state_;
  if (s.records.empty()) return;
  s.compressed.resize(ZSTD_compressBound(s.records.size()));
  const std::size_t size = ZSTD_compress(s.compressed.data(), s.compressed.size(), s.records.data(),
                                         s.records.size(), kCompression);
  if (ZSTD_isError(size) != 0) throw Error(std::string("zstd: ") + ZSTD_getErrorName(size));
  const std::uint64_t begin = s.at;
  s.put_record(kChunkRecord, Content()
                                 .time(s.span.begin())
                                 .time(s.span.end())
                                 .number(static_cast<std::uint64_t>(s.records.size()))
                                 .number(crc_of(s.records))
                                 .text("zstd")
                                 .number(static_cast<std::uint64_t>(size))
                                 .raw(std::string_view(s.compressed).substr(0, size))
                                 .bytes());
  const std::uint64_t length = s.at - begin;
  Content offsets;
  for (const auto& [channel, entries] : s.index) {
    offsets.number(channel).number(s.at);
    Content list;
    for (const auto& [time, offset] : entries) list.time(time).number(offset);
    s.put_record(kMessageIndex, Content().number(channel).text(list.bytes()).bytes());
  }
  s.chunk_indices.push_back(Content()
                                .time(s.span.begin())
                                .time(s.span.end())
                                .number(begin)
                                .number(length)
                                .text(offsets.bytes())
                                .number(s.at - begin - length)
                                .text("zstd")
                                .number(static_cast<std::uint64_t>(size))
                                .number(static_cast<std::uint64_t>(s.records.size()))
                                .bytes());
  s.records.clear();
  s.index.clear();
  s.span = {};
}

void Writer::attach(const Attachment& attachment) {
  State& s = *state_;
  end_chunk();
  std::string content = Content()
                            .time(s.all.end())
                            .time(s.all.end())
                            .text(attachment.name)
                            .text(attachment.media_type)
                            .number(static_cast<std::uint64_t>(attachment.data.size()))
                            .raw(attachment.data)
                            .bytes();
  content += Content().number(crc_of(content)).bytes();
  const std::uint64_t begin = s.at;
  s.put_record(kAttachment, content);
  s.attachment_indices.push_back(Content()
                                     .number(begin)
                                     .number(s.at - begin)
                                     .time(s.all.end())
                                     .time(s.all.end())
                                     .number(static_cast<std::uint64_t>(attachment.data.size()))
                                     .text(attachment.name)
                                     .text(attachment.media_type)
                                     .bytes());
}

void Writer::add_metadata(const std::string& name, const Texts& texts) {
  State& s = *state_;
  end_chunk();
  const std::uint64_t begin = s.at;
  s.put_record(kMetadata, Content().text(name).texts(texts).bytes());
  s.metadata_indices.push_back(Content().number(begin).number(s.at - begin).text(name).bytes());
}

void Writer::finish() {
  State& s = *state_;
  end_chunk();
  s.put_record(kDataEnd, Content().number(std::uint32_t{0}).bytes());

  std::string summary, offsets;
  const std::uint64_t begin = s.at;
  const auto group = [&](Opcode opcode, const std::vector<std::string>& contents) {
    if (contents.empty()) return;
    const std::uint64_t start = begin + summary.size();
    for (const std::string& content : contents) append_record(summary, opcode, content);
    append_record(offsets, kSummaryOffset,
                  Content()
                      .number(static_cast<std::uint8_t>(opcode))
                      .number(start)
                      .number(begin + summary.size() - start)
                      .bytes());
  };
  std::vector<std::string> schemas, channels;
  for (const Schema& schema : s.schemas) schemas.push_back(content_of(schema));
  for (const Channel& channel : s.channels) channels.push_back(content_of(channel));
  group(kSchema, schemas);
  group(kChannel, channels);
  Content counts;
  for (const auto& [channel, count] : s.counts) counts.number(channel).number(count);
  group(kStatistics, {Content()
                          .number(s.messages)
                          .number(static_cast<std::uint16_t>(s.schemas.size()))
                          .number(static_cast<std::uint32_t>(s.channels.size()))
                          .number(static_cast<std::uint32_t>(s.attachment_indices.size()))
                          .number(static_cast<std::uint32_t>(s.metadata_indices.size()))
                          .number(static_cast<std::uint32_t>(s.chunk_indices.size()))
                          .time(s.all.begin())
                          .time(s.all.end())
                          .text(counts.bytes())
                          .bytes()});
  group(kChunkIndex, s.chunk_indices);
  group(kAttachmentIndex, s.attachment_indices);
  group(kMetadataIndex, s.metadata_indices);

  const std::uint64_t offsets_at = begin + summary.size();
  summary += offsets;
  // the sum goes to where it stands itself
  std::string footer = Content().number(begin).number(offsets_at).bytes();
  const std::uint64_t size = footer.size() + sizeof(std::uint32_t);
  summary.push_back(static_cast<char>(kFooter));
  summary.append(reinterpret_cast<const char*>(&size), sizeof size);
  summary += footer;
  summary += Content().number(crc_of(summary)).bytes();
  s.put(summary);
  s.put(kMagic);
  const int file = s.file;
  s.file = -1;
  if (close(file) != 0) s.fail(errno);
}

std::uint64_t Writer::messages() const { return state_->messages; }
std::uint64_t Writer::bytes() const { return state_->at; }

namespace {

/// What is wrong with a record.
class Damaged : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The content of a record, as it is taken apart.
class Parts {
 public:
  explicit Parts(std::string_view bytes) : bytes_(bytes) {}

  template <typename T>
  T number() {
    T value;
    std::memcpy(&value, raw(sizeof value).data(), sizeof value);
    return value;
  }
  std::int64_t time() { return static_cast<std::int64_t>(number<std::uint64_t>()); }
  std::string_view raw(std::uint64_t size) {
    if (size > bytes_.size()) throw Damaged("a record is shorter than what is in it");
    const std::string_view part = bytes_.substr(0, size);
    bytes_.remove_prefix(size);
    return part;
  }
  std::string_view text() { return raw(number<std::uint32_t>()); }
  Texts texts() {
    Parts pairs(text());
    Texts texts;
    while (!pairs.rest().empty()) {
      std::string key(pairs.text());
      texts[std::move(key)] = pairs.text();
    }
    return texts;
  }
  std::string_view rest() const { return bytes_; }

 private:
  std::string_view bytes_;
};

/// Bytes from wherever they are.
class Source {
 public:
  virtual ~Source() = default;
  /// @return what there is, at most so many
  virtual std::string_view take(std::uint64_t size) = 0;
};

class Text final : public Source {
 public:
  explicit Text(std::string_view bytes) : bytes_(bytes) {}
  std::string_view take(std::uint64_t size) override {
    const std::string_view part = bytes_.substr(0, size);
    bytes_.remove_prefix(part.size());
    return part;
  }

 private:
  std::string_view bytes_;
};

class File final : public Source {
 public:
  explicit File(const std::filesystem::path& path) : file_(std::fopen(path.c_str(), "rbe")) {
    if (!file_) throw Error("cannot read " + path.string() + ": " + std::strerror(errno));
  }
  std::string_view take(std::uint64_t size) override {
    // a length that is a lie costs no more than what the file has
    constexpr std::uint64_t kStep = 1U << 22;
    std::size_t got = 0;
    while (got < size) {
      const auto step = static_cast<std::size_t>(std::min(kStep, size - got));
      if (buffer_.size() < got + step) buffer_.resize(got + step);
      const std::size_t read = std::fread(buffer_.data() + got, 1, step, file_.get());
      got += read;
      if (read < step) break;
    }
    return std::string_view(buffer_).substr(0, got);
  }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::unique_ptr<std::FILE, Close> file_;
  std::string buffer_;
};

class Reading {
 public:
  Reading(Source& source, Listener& listener) : source_(source), listener_(listener) {}

  Ending run() {
    if (source_.take(kMagic.size()) != kMagic) throw Error("it does not begin as an MCAP does");
    try {
      while (true) {
        const std::string_view head = source_.take(9);
        if (head.size() < 9) return {false, "it is cut off"};
        Parts parts(head);
        const auto opcode = parts.number<std::uint8_t>();
        const auto size = parts.number<std::uint64_t>();
        if (size > kLargestRecord)
          return {false, fmt::format("a record of {} bytes, 1 GiB is the most", size)};
        const std::string_view content = source_.take(size);
        if (content.size() < size) return {false, "it is cut off"};
        if (opcode == kDataEnd || opcode == kFooter) return {true, ""};
        record(opcode, content, false);
        if (listener_.has_enough()) return {true, ""};
      }
    } catch (const Damaged& damaged) {
      return {false, damaged.what()};
    }
  }

 private:
  void record(std::uint8_t opcode, std::string_view content, bool in_chunk) {
    Parts parts(content);
    switch (opcode) {
      case kSchema: {
        Schema schema;
        schema.id = parts.number<std::uint16_t>();
        schema.name = parts.text();
        schema.encoding = parts.text();
        schema.text = parts.text();
        // the same once more is allowed
        if (schemas_.insert(schema.id).second) listener_.hear(schema);
        break;
      }
      case kChannel: {
        Channel channel;
        channel.id = parts.number<std::uint16_t>();
        channel.schema = parts.number<std::uint16_t>();
        channel.topic = parts.text();
        channel.encoding = parts.text();
        channel.metadata = parts.texts();
        if (channel.schema != 0 && schemas_.count(channel.schema) == 0)
          throw Damaged(
              fmt::format("channel {} has a schema that did not come before it", channel.id));
        if (channels_.insert(channel.id).second) listener_.hear(channel);
        break;
      }
      case kMessage: {
        Message message;
        message.channel = parts.number<std::uint16_t>();
        message.sequence = parts.number<std::uint32_t>();
        message.log_ns = parts.time();
        message.publish_ns = parts.time();
        message.data = reinterpret_cast<const std::uint8_t*>(parts.rest().data());
        message.size = parts.rest().size();
        if (channels_.count(message.channel) == 0)
          throw Damaged(fmt::format("a message of channel {}, which did not come before it",
                                    message.channel));
        listener_.hear(message);
        break;
      }
      case kChunkRecord:
        if (in_chunk) throw Damaged("a chunk in a chunk");
        chunk(parts);
        break;
      case kAttachment: {
        (void)parts.time();
        (void)parts.time();
        Attachment attachment;
        attachment.name = parts.text();
        attachment.media_type = parts.text();
        attachment.data = parts.raw(parts.number<std::uint64_t>());
        const auto crc = parts.number<std::uint32_t>();
        if (crc != 0 && crc != crc_of(content.substr(0, content.size() - sizeof crc)))
          throw Damaged("the checksum of attachment " + attachment.name + " is wrong");
        listener_.hear(attachment);
        break;
      }
      case kMetadata: {
        const std::string name(parts.text());
        listener_.hear(name, parts.texts());
        break;
      }
      default:
        break;  // an index, or what a later version has
    }
  }

  void chunk(Parts& parts) {
    (void)parts.time();
    (void)parts.time();
    const auto size = parts.number<std::uint64_t>();
    const auto crc = parts.number<std::uint32_t>();
    const std::string_view compression = parts.text();
    const std::string_view packed = parts.raw(parts.number<std::uint64_t>());
    if (size > kLargestRecord)
      throw Damaged(fmt::format("a chunk of {} bytes, 1 GiB is the most", size));
    std::string_view records = packed;
    if (compression == "zstd") {
      // what the frame says of itself, so that a length that is a lie takes no memory
      if (ZSTD_getFrameContentSize(packed.data(), packed.size()) != size)
        throw Damaged("a chunk is not as long as it says");
      unpacked_.resize(size);
      const std::size_t got =
          ZSTD_decompress(unpacked_.data(), unpacked_.size(), packed.data(), packed.size());
      if (ZSTD_isError(got) != 0 || got != size) throw Damaged("a chunk cannot be unpacked");
      records = unpacked_;
    } else if (!compression.empty()) {
      throw Damaged(
          fmt::format("a chunk's compression is {}; zstd or none can be read", compression));
    }
    if (crc != 0 && crc != crc_of(records)) throw Damaged("a chunk's checksum is wrong");
    Parts inside(records);
    while (!inside.rest().empty() && !listener_.has_enough()) {
      const auto opcode = inside.number<std::uint8_t>();
      record(opcode, inside.raw(inside.number<std::uint64_t>()), true);
    }
  }

  Source& source_;
  Listener& listener_;
  std::string unpacked_;
  std::set<std::uint16_t> schemas_, channels_;
};

}  // namespace

Ending read(const std::filesystem::path& path, Listener& listener) {
  File file(path);
  try {
    return Reading(file, listener).run();
  } catch (const Error& error) {
    throw Error(path.string() + ": " + error.what());
  }
}

Ending read_bytes(std::string_view bytes, Listener& listener) {
  Text text(bytes);
  return Reading(text, listener).run();
}

}  // namespace c3rt::mcap
