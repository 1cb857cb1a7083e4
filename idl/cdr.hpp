#pragma once
// A sample's bytes as they cross the network: plain CDR (XCDR1), little endian, behind an
// encapsulation of four bytes (OMG DDS-XTypes 1.3, 7.4.3). Recordings keep samples so.
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <vector>

#include "c3rt_fields.h"  // generated from idl/c3rt.idl

namespace c3rt::wire {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "what is sent is little endian");

using Bytes = std::vector<std::uint8_t>;

namespace cdr {

constexpr std::size_t kEncapsulation = 4;  // {0, representation, 0, bytes of padding at the end}
constexpr std::uint8_t kPlainLittleEndian = 1;
constexpr std::size_t kEnd = 4;  // all of it is a multiple of this

template <typename T>
constexpr bool kIsText = std::is_array_v<T>&& std::is_same_v<std::remove_extent_t<T>, char>;

class Encoder {
 public:
  explicit Encoder(Bytes& out) : out_(out) {}

  template <typename T>
  void operator()(const T& value) {
    if constexpr (kIsText<T>) {
      const auto length = static_cast<std::uint32_t>(strnlen(value, sizeof value - 1) + 1);
      (*this)(length);
      out_.insert(out_.end(), value, value + length - 1);
      out_.push_back(0);
    } else if constexpr (std::is_array_v<T>) {
      for (const auto& element : value) (*this)(element);
    } else if constexpr (std::is_class_v<T>) {
      visit_in_order(value, *this);
    } else {
      const std::size_t at = out_.size() - kEncapsulation;
      out_.resize(out_.size() + (sizeof value - at % sizeof value) % sizeof value);
      const auto* bytes = reinterpret_cast<const std::uint8_t*>(&value);
      out_.insert(out_.end(), bytes, bytes + sizeof value);
    }
  }

 private:
  Bytes& out_;
};

class Decoder {
 public:
  Decoder(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}
  bool good() const { return good_; }

  template <typename T>
  void operator()(T& value) {
    if constexpr (kIsText<T>) {
      std::uint32_t length = 0;
      (*this)(length);
      good_ = good_ && length >= 1 && length <= sizeof value && length <= size_ - at_ &&
              data_[at_ + length - 1] == 0;
      if (!good_) return;
      std::memcpy(value, data_ + at_, length);
      at_ += length;
    } else if constexpr (std::is_array_v<T>) {
      for (auto& element : value) (*this)(element);
    } else if constexpr (std::is_class_v<T>) {
      visit_in_order(value, *this);
    } else {
      at_ += (sizeof value - at_ % sizeof value) % sizeof value;
      good_ = good_ && at_ <= size_ && sizeof value <= size_ - at_;
      if (!good_) return;
      if constexpr (std::is_same_v<T, bool>) {
        good_ = data_[at_] <= 1;
        value = data_[at_] == 1;
      } else {
        std::memcpy(&value, data_ + at_, sizeof value);
      }
      at_ += sizeof value;
    }
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
  std::size_t at_ = 0;
  bool good_ = true;
};

}  // namespace cdr

/// @param out is overwritten; it keeps its room
template <typename T>
void to_cdr(const T& sample, Bytes& out) {
  out.assign({0, cdr::kPlainLittleEndian, 0, 0});
  cdr::Encoder encoder(out);
  encoder(sample);
  const std::size_t padding = (cdr::kEnd - out.size() % cdr::kEnd) % cdr::kEnd;
  out.resize(out.size() + padding);
  out[3] = static_cast<std::uint8_t>(padding);
}

/// @return false if these are not the bytes of such a sample; `sample` is then of no use. Whether
/// its values make sense is validate()'s to say.
template <typename T>
bool from_cdr(const std::uint8_t* data, std::size_t size, T& sample) {
  if (size < cdr::kEncapsulation || data[0] != 0 || data[1] != cdr::kPlainLittleEndian)
    return false;
  sample = T{};
  cdr::Decoder decoder(data + cdr::kEncapsulation, size - cdr::kEncapsulation);
  decoder(sample);
  return decoder.good();
}

}  // namespace c3rt::wire
