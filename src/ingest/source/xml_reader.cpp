#include "ingest/source/xml_reader.h"

#include <expat.h>
#include <fmt/format.h>

#include <memory>
#include <new>

namespace kiln {
namespace {

constexpr std::size_t kStepBytes = 1 << 16;
constexpr std::uint64_t kLongestTag = 1 << 20;
constexpr std::size_t kDeepest = 32;

}  // namespace

std::optional<std::string> XmlAttributes::find(std::string_view name) const {
  for (const char** pair = pairs_; *pair != nullptr; pair += 2)
    if (name == *pair) return std::string(pair[1]);
  return std::nullopt;
}

void XmlReader::fail(const std::string& what, ErrorCode code) const {
  throw Error(code, file_.path(), fmt::format("line {}", line_), what);
}

/// The parser and its handlers. No exception may pass through Expat's frames, so an exception is kept and thrown behind
/// them.
class XmlReader::Expat {
 public:
  explicit Expat(XmlReader& reader) : reader_(reader), parser_(XML_ParserCreate(nullptr), &XML_ParserFree) {
    if (!parser_) throw std::bad_alloc();
    XML_SetUserData(parser_.get(), this);
    XML_SetElementHandler(parser_.get(), &onBegin, &onEnd);
    XML_SetCharacterDataHandler(parser_.get(), &onText);
    XML_SetStartDoctypeDeclHandler(parser_.get(), &onDoctype);
  }

  void parse() {
    for (std::uint64_t at = 0;;) {
      void* const buffer = XML_GetBuffer(parser_.get(), kStepBytes);
      if (buffer == nullptr) throw std::bad_alloc();
      const std::size_t got = reader_.file_.readSomeAt(at, {static_cast<std::byte*>(buffer), kStepBytes});
      at += got;
      const XML_Status status = XML_ParseBuffer(parser_.get(), static_cast<int>(got), got == 0);
      if (reader_.thrown_) std::rethrow_exception(reader_.thrown_);
      if (reader_.stopped_) return;
      note();
      if (status != XML_STATUS_OK)
        reader_.fail(
            fmt::format("the XML is cut short or damaged ({})", XML_ErrorString(XML_GetErrorCode(parser_.get()))));
      if (got == 0) return;
      if (at > place() + kLongestTag) reader_.fail("a tag of the XML has no end");
    }
  }

 private:
  std::uint64_t place() const { return static_cast<std::uint64_t>(XML_GetCurrentByteIndex(parser_.get())); }
  void note() {
    reader_.line_ = XML_GetCurrentLineNumber(parser_.get());
    reader_.after_tag_ = place() + static_cast<std::uint64_t>(XML_GetCurrentByteCount(parser_.get()));
  }

  // Expat may call handlers after a request to stop.
  template <class Handle>
  static void guarded(void* self, Handle handle, bool has_place = true) {
    Expat& expat = *static_cast<Expat*>(self);
    XmlReader& reader = expat.reader_;
    if (reader.thrown_ || reader.stopped_) return;
    if (has_place) expat.note();
    try {
      handle(reader);
    } catch (...) {
      reader.thrown_ = std::current_exception();
    }
    if (reader.thrown_ || reader.stopped_) XML_StopParser(expat.parser_.get(), XML_FALSE);
  }

  static void XMLCALL onBegin(void* self, const XML_Char* name, const XML_Char** attributes) {
    guarded(self, [&](XmlReader& reader) {
      if (reader.open_.size() == kDeepest) reader.fail(fmt::format("elements lie more than {} deep", kDeepest));
      reader.open_.emplace_back(name);
      reader.begin(name, XmlAttributes(attributes));
    });
  }
  static void XMLCALL onEnd(void* self, const XML_Char*) {
    guarded(self, [&](XmlReader& reader) {
      reader.end();
      reader.open_.pop_back();
    });
  }
  static void XMLCALL onText(void* self, const XML_Char* text, int length) {
    guarded(
        self,
        [&](XmlReader& reader) {
          reader.text({text, static_cast<std::size_t>(length)});
        },
        false);
  }
  static void XMLCALL onDoctype(void* self, const XML_Char*, const XML_Char*, const XML_Char*, int) {
    guarded(self, [&](XmlReader& reader) { reader.fail("has a document type, which headers of volumes have not"); });
  }

  XmlReader& reader_;
  std::unique_ptr<std::remove_pointer_t<XML_Parser>, decltype(&XML_ParserFree)> parser_;
};

void XmlReader::parse() { Expat(*this).parse(); }

}  // namespace kiln
