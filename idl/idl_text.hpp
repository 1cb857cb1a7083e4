#pragma once

namespace c3rt::wire {

/// c3rt.idl as it stands, for those who read what we send without us: recordings carry it.
const char* idl_text() noexcept;

}  // namespace c3rt::wire
