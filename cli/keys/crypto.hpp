#pragma once
// The one place that names OpenSSL: keys, certificates, signed documents.
#include <cstdint>
#include <ctime>
#include <memory>
#include <stdexcept>
#include <string>

namespace c3rt::cli::keys {

/// A text that is no key, certificate or signed document, or one that does not verify.
class CryptoError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Period {
  std::time_t not_before = 0, not_after = 0;
};

class Certificate;

/// A private key on the curve P-256.
class Key {
 public:
  static Key make();
  /// @throws CryptoError
  static Key read(const std::string& pem);
  std::string pem() const;

 private:
  friend class Certificate;
  friend std::string sign(const std::string&, const Certificate&, const Key&);
  std::shared_ptr<void> key_;
};

/// An X.509 certificate.
class Certificate {
 public:
  /// Of an authority, signed by itself.
  static Certificate make_authority(const std::string& name, const Key& key, const Period& period);
  /// Of `key`'s owner, signed by the authority.
  static Certificate make(const std::string& name, const Key& key, const Certificate& authority,
                          const Key& authority_key, const Period& period);
  /// @throws CryptoError
  static Certificate read(const std::string& pem);

  std::string pem() const;
  std::string subject() const;  // RFC 2253: "CN=planner"
  std::string issuer() const;
  Period period() const;
  bool is_of(const Key& key) const;
  bool is_signed_by(const Certificate& authority) const;

 private:
  friend std::string sign(const std::string&, const Certificate&, const Key&);
  friend std::string verify(const std::string&, const Certificate&);
  static Certificate build(const std::string& name, const Key& key, const Certificate* authority,
                           const Key& signer, const Period& period);
  std::shared_ptr<void> certificate_;
};

/// The text with its signature, as S/MIME (multipart/signed). @throws CryptoError
std::string sign(const std::string& text, const Certificate& authority, const Key& authority_key);

/// The text of a document that the authority signed; when that was does not matter.
/// @throws CryptoError where it is no such document
std::string verify(const std::string& document, const Certificate& authority);

}  // namespace c3rt::cli::keys
