#include "cli/keys/keystore.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <optional>
#include <set>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cli/keys/crypto.hpp"
#include "idl/discovery.hpp"
#include "idl/security.hpp"

namespace c3rt::cli::keys {
namespace fs = std::filesystem;
namespace file = wire::key_file;
namespace {

constexpr std::time_t kDay = 86400;
constexpr mode_t kPrivate = 0600, kPublic = 0644, kFolder = 0755;
constexpr const char* kAnew = "make them anew, and copy them to every host: c3rt keys init --force";

std::string formatted(std::time_t time, const char* format) {
  std::tm parts{};
  char text[64];
  std::strftime(text, sizeof text, format, gmtime_r(&time, &parts));
  return text;
}
/// As permissions write it.
std::string xml_time(std::time_t time) { return formatted(time, "%Y-%m-%dT%H:%M:%S"); }

void write(const fs::path& path, const std::string& text, mode_t mode) {
  const int descriptor = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
  int error = descriptor < 0 ? errno : 0;
  // whatever the umask takes away
  if (error == 0 && fchmod(descriptor, mode) != 0) error = errno;
  for (std::size_t done = 0; error == 0 && done < text.size();) {
    const ssize_t count = ::write(descriptor, text.data() + done, text.size() - done);
    if (count >= 0) {
      done += static_cast<std::size_t>(count);
    } else if (errno != EINTR) {
      error = errno;
    }
  }
  if (error == 0 && fsync(descriptor) != 0) error = errno;
  if (descriptor >= 0) close(descriptor);
  if (error != 0)
    throw std::runtime_error("cannot write " + path.string() + ": " + std::strerror(error));
}

void make_directory(const fs::path& path) {
  if (mkdir(path.c_str(), kFolder) != 0 || chmod(path.c_str(), kFolder) != 0)
    throw std::runtime_error("cannot make " + path.string() + ": " + std::strerror(errno));
}

/// A folder beside the wanted one, which goes with everything in it unless it was renamed.
class Draft {
 public:
  explicit Draft(const fs::path& wanted)
      : path_(wanted.parent_path() /
              fmt::format(".{}-{}.part", wanted.filename().string(), getpid())) {
    make_directory(path_);
  }
  ~Draft() {
    std::error_code error;
    fs::remove_all(path_, error);
  }
  Draft(const Draft&) = delete;
  Draft& operator=(const Draft&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// Nothing lies there but what a keystore has.
bool is_keystore(const fs::path& folder) {
  std::set<std::string> known{file::kAuthority, file::kAuthorityKey, file::kGovernance};
  for (const wire::Identity& identity : wire::kIdentities) known.insert(identity.name);
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (known.count(entry.path().filename().string()) == 0) return false;
  return !error && fs::exists(folder / file::kAuthority);
}

void fill(const fs::path& folder, const Period& period) {
  const Key authority_key = Key::make();
  // a name of its own, so that two keystores can be told apart
  const Certificate authority = Certificate::make_authority(
      fmt::format("c3rt keys of {}, {}", wire::host_name(), date(period.not_before + kClockSkew)),
      authority_key, period);
  write(folder / file::kAuthority, authority.pem(), kPublic);
  write(folder / file::kAuthorityKey, authority_key.pem(), kPrivate);
  write(folder / file::kGovernance, sign(wire::governance(), authority, authority_key), kPublic);
  for (const wire::Identity& identity : wire::kIdentities) {
    const fs::path own = folder / identity.name;
    make_directory(own);
    const Key key = Key::make();
    const Certificate certificate =
        Certificate::make(identity.name, key, authority, authority_key, period);
    const std::string may = wire::permissions(
        identity, certificate.subject(), xml_time(period.not_before), xml_time(period.not_after));
    write(own / file::kCertificate, certificate.pem(), kPublic);
    write(own / file::kKey, key.pem(), kPrivate);
    write(own / file::kPermissions, sign(may, authority, authority_key), kPublic);
  }
}

/// Looks at one keystore.
class Check {
 public:
  Check(const fs::path& folder, std::time_t now) : folder_(folder), now_(now) {}

  Findings all(const std::vector<std::string>& identities) {
    std::error_code error;
    if (!fs::is_directory(folder_, error)) {
      complain("", fmt::format("there are no keys in {}", folder_.string()),
               fmt::format("make them: c3rt keys init{}; or say where they are: export "
                           "C3RT_KEYS=DIR",
                           folder_ == wire::keys_directory() ? "" : " --out " + folder_.string()));
      return found_;
    }
    const auto authority = read<Certificate>("", file::kAuthority);
    if (!authority) return found_;
    look_at_period("", "the authority's certificate", authority->period());
    signed_document("", file::kGovernance, *authority, wire::governance());
    for (const std::string& name : identities) look_at(name, *authority);
    return found_;
  }

 private:
  void complain(const std::string& identity, const std::string& text, const std::string& advice) {
    found_.problems.push_back({identity, text, advice});
  }

  /// The file's text; a complaint where there is none.
  std::optional<std::string> text_of(const std::string& identity, const std::string& name) {
    const fs::path path = folder_ / name;
    if (access(path.c_str(), R_OK) == 0) return read_text(path);
    const int reason = errno;
    if (reason == ENOENT) {
      complain(identity, fmt::format("{} is missing", path.string()),
               "copy it from where the keys were made, or " + std::string(kAnew));
    } else {
      complain(
          identity,
          fmt::format("{} cannot be read by this user: {}", path.string(), std::strerror(reason)),
          "run as the user that the keys belong to, or name others: export C3RT_KEYS=DIR");
    }
    return std::nullopt;
  }
  template <typename T>
  std::optional<T> read(const std::string& identity, const std::string& name) {
    const auto text = text_of(identity, name);
    if (!text) return std::nullopt;
    try {
      return T::read(*text);
    } catch (const CryptoError& error) {
      complain(identity, fmt::format("{}: {}", (folder_ / name).string(), error.what()), kAnew);
      return std::nullopt;
    }
  }

  void look_at_period(const std::string& identity, const std::string& what, const Period& period) {
    if (found_.expires == 0 || period.not_after < found_.expires) found_.expires = period.not_after;
    if (now_ < period.not_before) {
      complain(identity,
               fmt::format("{} is not valid before {}, and this host's clock says {}", what,
                           date(period.not_before), date(now_)),
               "set this host's clock if it is behind (date -u; timedatectl set-ntp true); if the "
               "clock was wrong where the keys were made, " +
                   std::string(kAnew));
    } else if (now_ >= period.not_after) {
      complain(identity,
               fmt::format("{} expired on {}, and this host's clock says {}", what,
                           date(period.not_after), date(now_)),
               std::string(kAnew) + "; if the clock is wrong, set it (date -u)");
    }
  }

  /// @param expected the text, but for dates
  void signed_document(const std::string& identity, const std::string& name,
                       const Certificate& authority, const std::string& expected) {
    const auto text = text_of(identity, name);
    if (!text) return;
    try {
      // mail has lines that end in CR LF
      std::string content = verify(*text, authority);
      content.erase(std::remove(content.begin(), content.end(), '\r'), content.end());
      if (content != expected)
        complain(identity,
                 fmt::format("{} is not what the topics of this version need",
                             (folder_ / name).string()),
                 kAnew);
    } catch (const CryptoError& error) {
      complain(identity,
               fmt::format("{} is {} ({})", (folder_ / name).string(), error.what(),
                           authority.subject()),
               "copy it from where the keys were made, or " + std::string(kAnew));
    }
  }

  void look_at(const std::string& name, const Certificate& authority) {
    const auto* const known =
        std::find_if(wire::kIdentities.begin(), wire::kIdentities.end(),
                     [&](const wire::Identity& identity) { return name == identity.name; });
    const auto certificate = read<Certificate>(name, name + "/" + file::kCertificate);
    const auto key = read<Key>(name, name + "/" + file::kKey);
    if (key) look_at_mode(name);
    if (!certificate || known == wire::kIdentities.end()) return;
    if (!certificate->is_signed_by(authority)) {
      complain(name,
               fmt::format("the certificate of {} is foreign: it was signed by {}, and {} is of {}",
                           name, certificate->issuer(), (folder_ / file::kAuthority).string(),
                           authority.subject()),
               "copy the whole folder of one keystore, or " + std::string(kAnew));
      return;
    }
    if (certificate->subject() != "CN=" + name)
      complain(
          name,
          fmt::format("the certificate of {} is another one's: {}", name, certificate->subject()),
          "copy the folder of each identity to its own name");
    look_at_period(name, "the certificate of " + name, certificate->period());
    if (key && !certificate->is_of(*key))
      complain(name, fmt::format("the key of {} does not belong to its certificate", name),
               "copy both from where the keys were made, or " + std::string(kAnew));
    const Period period = certificate->period();
    signed_document(name, name + "/" + file::kPermissions, authority,
                    wire::permissions(*known, certificate->subject(), xml_time(period.not_before),
                                      xml_time(period.not_after)));
  }

  void look_at_mode(const std::string& name) {
    const fs::path path = folder_ / name / file::kKey;
    struct stat status {};
    if (stat(path.c_str(), &status) == 0 && (status.st_mode & 077) != 0)
      complain(
          name,
          fmt::format("{} is open to others (mode {:04o})", path.string(), status.st_mode & 07777),
          "chmod 600 " + path.string());
  }

  fs::path folder_;
  std::time_t now_;
  Findings found_;
};

}  // namespace

std::vector<std::string> identity_names() {
  std::vector<std::string> names;
  for (const wire::Identity& identity : wire::kIdentities) names.emplace_back(identity.name);
  return names;
}

std::string date(std::time_t time) { return formatted(time, "%Y-%m-%d %H:%M:%S UTC"); }

void make(const fs::path& given, int days, bool force, std::time_t now) {
  fs::path folder = fs::weakly_canonical(fs::absolute(given));
  if (!folder.has_filename()) folder = folder.parent_path();
  std::error_code error;
  const bool taken = fs::exists(folder, error) && !fs::is_empty(folder, error);
  if (taken && !is_keystore(folder))
    throw UsageError(folder.string() + " has something else in it than keys; choose another --out");
  if (taken && !force)
    throw UsageError(fmt::format(
        "there are keys in {} already; --force makes new ones, which the old ones' owners cannot "
        "talk to",
        folder.string()));
  make_folder(folder.parent_path());
  const Draft draft(folder);
  fill(draft.path(), {now - kClockSkew, now + days * kDay});
  // in one step: whoever looks finds the old ones or the new ones whole, and the draft takes the
  // old ones away
  if (renameat2(AT_FDCWD, draft.path().c_str(), AT_FDCWD, folder.c_str(),
                taken ? RENAME_EXCHANGE : 0) != 0)
    throw std::runtime_error("cannot put the keys to " + folder.string() + ": " +
                             std::strerror(errno));
}

Findings check(const fs::path& folder, const std::vector<std::string>& identities,
               std::time_t now) {
  return Check(folder, now).all(identities);
}

void require_keys(const fs::path& profile, const std::vector<std::string>& identities) {
  if (!wire::is_secure(read_text(profile))) return;
  const Findings found = check(wire::keys_directory(), identities, std::time(nullptr));
  if (found.problems.empty()) return;
  std::string text = "the keys that the DDS profile " + profile.string() + " needs:";
  for (const Complaint& complaint : found.problems)
    text += "\n  " + complaint.text + "\n    " + complaint.advice;
  throw UsageError(text);
}

}  // namespace c3rt::cli::keys
