#include "cli/keys/crypto.hpp"

#include <openssl/bio.h>
#include <openssl/bn.h>
#include <openssl/ec.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/pkcs7.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>

namespace c3rt::cli::keys {
namespace {

using Bio = std::unique_ptr<BIO, decltype(&BIO_free)>;

[[noreturn]] void fail(const std::string& what) {
  char reason[256] = "";
  const unsigned long code = ERR_peek_last_error();
  if (code != 0) ERR_error_string_n(code, reason, sizeof reason);
  ERR_clear_error();
  throw CryptoError(what + (*reason != '\0' ? std::string(" (") + reason + ")" : ""));
}
void require(bool done, const char* what) {
  if (!done) fail(what);
}

Bio memory() { return {BIO_new(BIO_s_mem()), &BIO_free}; }
/// Reads from the text, which has to live as long.
Bio memory(const std::string& text) {
  return {BIO_new_mem_buf(text.data(), static_cast<int>(text.size())), &BIO_free};
}
std::string text_of(BIO* bio) {
  char* data = nullptr;
  const long size = BIO_get_mem_data(bio, &data);
  return {data, static_cast<std::size_t>(size)};
}

EVP_PKEY* get(const std::shared_ptr<void>& key) { return static_cast<EVP_PKEY*>(key.get()); }
X509* certificate_of(const std::shared_ptr<void>& held) { return static_cast<X509*>(held.get()); }
std::shared_ptr<void> own(EVP_PKEY* key) {
  return {key, [](void* held) { EVP_PKEY_free(static_cast<EVP_PKEY*>(held)); }};
}
std::shared_ptr<void> own(X509* certificate) {
  return {certificate, [](void* held) { X509_free(static_cast<X509*>(held)); }};
}

std::string text_of(const X509_NAME* name) {
  const Bio out = memory();
  X509_NAME_print_ex(out.get(), name, 0, XN_FLAG_RFC2253);
  return text_of(out.get());
}

std::time_t seconds_of(const ASN1_TIME* time) {
  std::tm parts{};
  require(ASN1_TIME_to_tm(time, &parts) == 1, "a time that cannot be read");
  return timegm(&parts);
}

}  // namespace

Key Key::make() {
  Key made;
  made.key_ = own(EVP_EC_gen("P-256"));
  require(made.key_ != nullptr, "cannot make a key");
  return made;
}

Key Key::read(const std::string& pem) {
  const Bio in = memory(pem);
  Key found;
  // a file that is encrypted is refused instead of asking at the terminal
  found.key_ = own(PEM_read_bio_PrivateKey(in.get(), nullptr, nullptr, const_cast<char*>("")));
  require(found.key_ != nullptr, "not a private key in PEM");
  return found;
}

std::string Key::pem() const {
  const Bio out = memory();
  require(
      PEM_write_bio_PrivateKey(out.get(), get(key_), nullptr, nullptr, 0, nullptr, nullptr) == 1,
      "cannot write a key");
  return text_of(out.get());
}

Certificate Certificate::build(const std::string& name, const Key& key,
                               const Certificate* authority, const Key& signer,
                               const Period& period) {
  Certificate made;
  made.certificate_ = own(X509_new());
  X509* x509 = certificate_of(made.certificate_);
  require(x509 != nullptr && X509_set_version(x509, 2) == 1, "cannot make a certificate");
  constexpr int kSerialBits = 127;
  const std::unique_ptr<BIGNUM, decltype(&BN_free)> serial(BN_new(), &BN_free);
  require(BN_rand(serial.get(), kSerialBits, BN_RAND_TOP_ONE, BN_RAND_BOTTOM_ANY) == 1 &&
              BN_to_ASN1_INTEGER(serial.get(), X509_get_serialNumber(x509)) != nullptr,
          "cannot draw a serial number");
  require(ASN1_TIME_set(X509_getm_notBefore(x509), period.not_before) != nullptr &&
              ASN1_TIME_set(X509_getm_notAfter(x509), period.not_after) != nullptr,
          "cannot set the period of a certificate");
  X509_NAME* subject = X509_get_subject_name(x509);
  require(X509_NAME_add_entry_by_txt(subject, "CN", MBSTRING_UTF8,
                                     reinterpret_cast<const unsigned char*>(name.c_str()), -1, -1,
                                     0) == 1,
          "cannot name a certificate");
  X509* issuer = authority != nullptr ? certificate_of(authority->certificate_) : x509;
  require(X509_set_issuer_name(x509, X509_get_subject_name(issuer)) == 1 &&
              X509_set_pubkey(x509, get(key.key_)) == 1,
          "cannot make a certificate");
  const char* constraints = authority == nullptr ? "critical,CA:TRUE" : "critical,CA:FALSE";
  X509_EXTENSION* extension =
      X509V3_EXT_conf_nid(nullptr, nullptr, NID_basic_constraints, constraints);
  require(extension != nullptr, "cannot make a certificate");
  const int added = X509_add_ext(x509, extension, -1);
  X509_EXTENSION_free(extension);
  require(added == 1 && X509_sign(x509, get(signer.key_), EVP_sha256()) > 0,
          "cannot sign a certificate");
  return made;
}

Certificate Certificate::make_authority(const std::string& name, const Key& key,
                                        const Period& period) {
  return build(name, key, nullptr, key, period);
}

Certificate Certificate::make(const std::string& name, const Key& key, const Certificate& authority,
                              const Key& authority_key, const Period& period) {
  return build(name, key, &authority, authority_key, period);
}

Certificate Certificate::read(const std::string& pem) {
  const Bio in = memory(pem);
  Certificate found;
  found.certificate_ = own(PEM_read_bio_X509(in.get(), nullptr, nullptr, nullptr));
  require(found.certificate_ != nullptr, "not a certificate in PEM");
  return found;
}

std::string Certificate::pem() const {
  const Bio out = memory();
  require(PEM_write_bio_X509(out.get(), certificate_of(certificate_)) == 1,
          "cannot write a certificate");
  return text_of(out.get());
}

std::string Certificate::subject() const {
  return text_of(X509_get_subject_name(certificate_of(certificate_)));
}
std::string Certificate::issuer() const {
  return text_of(X509_get_issuer_name(certificate_of(certificate_)));
}

Period Certificate::period() const {
  const X509* x509 = certificate_of(certificate_);
  return {seconds_of(X509_get0_notBefore(x509)), seconds_of(X509_get0_notAfter(x509))};
}

bool Certificate::is_of(const Key& key) const {
  const bool same = X509_check_private_key(certificate_of(certificate_), get(key.key_)) == 1;
  ERR_clear_error();
  return same;
}

bool Certificate::is_signed_by(const Certificate& authority) const {
  const bool is = X509_verify(certificate_of(certificate_),
                              X509_get0_pubkey(certificate_of(authority.certificate_))) == 1;
  ERR_clear_error();
  return is;
}

std::string sign(const std::string& text, const Certificate& authority, const Key& authority_key) {
  constexpr int kFlags = PKCS7_TEXT | PKCS7_DETACHED | PKCS7_STREAM;
  const Bio in = memory(text), out = memory();
  const std::unique_ptr<PKCS7, decltype(&PKCS7_free)> document(
      PKCS7_sign(certificate_of(authority.certificate_), get(authority_key.key_), nullptr, in.get(),
                 kFlags),
      &PKCS7_free);
  require(
      document != nullptr && SMIME_write_PKCS7(out.get(), document.get(), in.get(), kFlags) == 1,
      "cannot sign a document");
  return text_of(out.get());
}

std::string verify(const std::string& document, const Certificate& authority) {
  const Bio in = memory(document), out = memory();
  BIO* content = nullptr;
  const std::unique_ptr<PKCS7, decltype(&PKCS7_free)> parsed(SMIME_read_PKCS7(in.get(), &content),
                                                             &PKCS7_free);
  const Bio detached(content, &BIO_free);
  require(parsed != nullptr && detached != nullptr, "not a document signed with S/MIME");
  const std::unique_ptr<STACK_OF(X509), void (*)(STACK_OF(X509)*)> signers(
      sk_X509_new_null(), [](STACK_OF(X509) * held) { sk_X509_free(held); });
  sk_X509_push(signers.get(), certificate_of(authority.certificate_));
  // the authority alone is trusted, whatever the document brings along; its period is judged by
  // itself
  const int verified = PKCS7_verify(parsed.get(), signers.get(), nullptr, detached.get(), out.get(),
                                    PKCS7_TEXT | PKCS7_NOVERIFY | PKCS7_NOINTERN);
  require(verified == 1, "not signed by this authority");
  return text_of(out.get());
}

}  // namespace c3rt::cli::keys
