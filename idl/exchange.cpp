#include "idl/exchange.hpp"

#include <algorithm>
#include <cstring>
#include <iterator>
#include <utility>

#include "idl/dds.hpp"

namespace c3rt::wire {

std::shared_ptr<Exchange> make_exchange() { return std::make_shared<Exchange>(); }

std::uint64_t Exchange::add_reader(Inbox& inbox) {
  const std::lock_guard lock(mutex_);
  OfTopic& topic = of(inbox.topic_);
  topic.readers.push_back(&inbox);
  inbox.sent_ = topic.newest_seq;
  return topic.newest_seq;
}

void Exchange::remove_reader(const Inbox& inbox) {
  const std::lock_guard lock(mutex_);
  std::vector<Inbox*>& readers = of(inbox.topic_).readers;
  readers.erase(std::remove(readers.begin(), readers.end(), &inbox), readers.end());
  for (auto held = held_.begin(); held != held_.end();)
    held = held->second.inbox == &inbox ? held_.erase(held) : std::next(held);
}

std::uint64_t Exchange::identity() {
  const std::lock_guard lock(mutex_);
  return ++identities_;
}

void Exchange::add_writer(const Topic& topic, std::uint64_t writer) {
  const std::lock_guard lock(mutex_);
  of(topic).writers.push_back(writer);
}

void Exchange::remove_writer(const Topic& topic, std::uint64_t writer) {
  const std::lock_guard lock(mutex_);
  std::vector<std::uint64_t>& writers = of(topic).writers;
  writers.erase(std::remove(writers.begin(), writers.end(), writer), writers.end());
}

bool Exchange::has_writer(const Topic& topic, std::uint64_t writer) {
  const std::lock_guard lock(mutex_);
  const std::vector<std::uint64_t>& writers = of(topic).writers;
  return std::find(writers.begin(), writers.end(), writer) != writers.end();
}

int Exchange::readers(const Topic& topic) {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(of(topic).readers.size());
}

int Exchange::writers(const Topic& topic) {
  const std::lock_guard lock(mutex_);
  return static_cast<int>(of(topic).writers.size());
}

void Exchange::set_filter_of(const Topic& topic, Filter filter) {
  const std::lock_guard lock(mutex_);
  of(topic).filter = std::move(filter);
}

bool Exchange::passes(const Topic& topic, void* sample) {
  const std::lock_guard lock(mutex_);
  const Filter& filter = of(topic).filter;
  return !filter || filter(sample);
}

void Exchange::set_line_of(const Topic& topic, std::uint64_t bus, Line line) {
  const std::lock_guard lock(mutex_);
  const Edge edge{topic.descriptor, bus};
  if (line) {
    lines_[edge] = std::move(line);
  } else {
    lines_.erase(edge);
  }
}

void Exchange::arrive(std::int64_t now_ns) {
  const std::lock_guard lock(mutex_);
  now_ns_ = now_ns;
  while (!held_.empty() && held_.begin()->first <= now_ns) {
    const Held& held = held_.begin()->second;
    deliver(*held.inbox, held.sample.data(), held.sender);
    held_.erase(held_.begin());
  }
}

void Exchange::put(const Topic& topic, const void* sample, const Sender& sender,
                   std::uint64_t seq) {
  const std::lock_guard lock(mutex_);
  of(topic).newest_seq = seq;
  const char* bytes = static_cast<const char*>(sample);
  for (Inbox* inbox : of(topic).readers) {
    inbox->sent_ = seq;
    send(*inbox, bytes, sender);
  }
}

void Exchange::send(Inbox& inbox, const char* bytes, const Sender& sender) {
  const auto line = lines_.find({inbox.topic_.descriptor, inbox.bus_});
  if (line == lines_.end()) {
    deliver(inbox, bytes, sender);
    return;
  }
  std::vector<char> copy(bytes, bytes + inbox.size_);
  const Passage passage = line->second(copy.data());
  for (int i = 0; i < passage.copies; ++i) {
    if (passage.delay_ns > 0) {
      held_.emplace(now_ns_ + passage.delay_ns, Held{&inbox, copy, sender});
    } else {
      deliver(inbox, copy.data(), sender);
    }
  }
}

void Exchange::deliver(Inbox& inbox, const char* bytes, const Sender& sender) {
  if (inbox.senders_.size() - inbox.taken_ == Inbox::kMostWaiting) ++inbox.taken_;
  if (inbox.taken_ == Inbox::kMostWaiting) {
    const auto taken = static_cast<std::ptrdiff_t>(inbox.taken_);
    inbox.samples_.erase(inbox.samples_.begin(),
                         inbox.samples_.begin() + taken * static_cast<std::ptrdiff_t>(inbox.size_));
    inbox.senders_.erase(inbox.senders_.begin(), inbox.senders_.begin() + taken);
    inbox.taken_ = 0;
  }
  inbox.samples_.insert(inbox.samples_.end(), bytes, bytes + inbox.size_);
  inbox.senders_.push_back(sender);
}

std::uint64_t Exchange::sent(const Inbox& inbox) {
  const std::lock_guard lock(mutex_);
  return inbox.sent_;
}

bool Exchange::take(Inbox& inbox, void* sample, Sender& sender) {
  const std::lock_guard lock(mutex_);
  if (inbox.taken_ == inbox.senders_.size()) return false;
  std::memcpy(sample, inbox.samples_.data() + inbox.taken_ * inbox.size_, inbox.size_);
  sender = inbox.senders_[inbox.taken_++];
  if (inbox.taken_ == inbox.senders_.size()) {
    inbox.taken_ = 0;
    inbox.samples_.clear();
    inbox.senders_.clear();
  }
  return true;
}

}  // namespace c3rt::wire
