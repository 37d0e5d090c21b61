// A worker (base/worker_loop.h) for JPEG 2000 files of a single component: openjpeg_reader MEMORY_BYTES SECONDS.
// Requests: ingest/pictures/openjpeg_protocol.h.
#include <openjpeg.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string>

#include "base/worker_loop.h"
#include "ingest/pictures/openjpeg_protocol.h"

namespace {

using kiln::Jpeg2000Head;
using kiln::WorkerRefusal;

/// The bytes of a file, as OpenJPEG reads them.
struct Bytes {
  const char* data;
  std::size_t size, at;
};

OPJ_SIZE_T readBytes(void* to, OPJ_SIZE_T count, void* from) {
  auto& bytes = *static_cast<Bytes*>(from);
  const std::size_t taken = std::min<std::size_t>(count, bytes.size - bytes.at);
  if (taken == 0) return static_cast<OPJ_SIZE_T>(-1);  // the end of the file
  std::memcpy(to, bytes.data + bytes.at, taken);
  bytes.at += taken;
  return taken;
}

OPJ_OFF_T skipBytes(OPJ_OFF_T count, void* from) {
  auto& bytes = *static_cast<Bytes*>(from);
  if (count < 0 || static_cast<std::size_t>(count) > bytes.size - bytes.at) return -1;
  bytes.at += static_cast<std::size_t>(count);
  return count;
}

OPJ_BOOL seekBytes(OPJ_OFF_T place, void* from) {
  auto& bytes = *static_cast<Bytes*>(from);
  if (place < 0 || static_cast<std::size_t>(place) > bytes.size) return OPJ_FALSE;
  bytes.at = static_cast<std::size_t>(place);
  return OPJ_TRUE;
}

/// Decodes a file; keeps the first message of OpenJPEG.
class Decoder {
 public:
  Decoder(const Jpeg2000Head& head, const char* data, std::size_t size)
      : head_(head),
        bytes_{data, size, 0},
        stream_(opj_stream_default_create(OPJ_TRUE), &opj_stream_destroy),
        codec_(opj_create_decompress(head.has_boxes != 0 ? OPJ_CODEC_JP2 : OPJ_CODEC_J2K), &opj_destroy_codec),
        image_(nullptr, &opj_image_destroy) {
    require(stream_ && codec_);
    opj_stream_set_user_data(stream_.get(), &bytes_, nullptr);
    opj_stream_set_user_data_length(stream_.get(), size);
    opj_stream_set_read_function(stream_.get(), readBytes);
    opj_stream_set_skip_function(stream_.get(), skipBytes);
    opj_stream_set_seek_function(stream_.get(), seekBytes);
    opj_set_error_handler(codec_.get(), keep, this);
    opj_set_warning_handler(codec_.get(), keep, this);
  }

  std::string run() {
    opj_dparameters_t parameters;
    opj_set_default_decoder_parameters(&parameters);
    require(opj_setup_decoder(codec_.get(), &parameters) != OPJ_FALSE);
    opj_image_t* image = nullptr;
    const bool has_header = opj_read_header(stream_.get(), codec_.get(), &image) != OPJ_FALSE;
    image_.reset(image);
    require(has_header);
    requireKnown();
    message_.clear();
    require(opj_decode(codec_.get(), stream_.get(), image) != OPJ_FALSE && message_.empty());
    require(opj_end_decompress(codec_.get(), stream_.get()) != OPJ_FALSE);
    requireKnown();
    require(image_->comps[0].data != nullptr);
    return head_.bits > 8 ? values<std::uint16_t>() : values<std::uint8_t>();
  }

 private:
  static void keep(const char* message, void* self) {
    std::string& kept = static_cast<Decoder*>(self)->message_;
    if (kept.empty()) kept = message;
  }

  void require(bool ok) const {
    if (ok) return;
    std::string why = message_.empty() ? "it failed" : message_;
    while (!why.empty() && (why.back() == '\n' || why.back() == ' ')) why.pop_back();
    throw WorkerRefusal("cannot be decoded; the file is cut short or damaged (OpenJPEG: " + why + ")");
  }

  // Kiln has parsed the size; OpenJPEG must find an equal size.
  void requireKnown() const {
    require(image_->numcomps == 1);
    const opj_image_comp_t& values = image_->comps[0];
    require(values.w == head_.columns && values.h == head_.rows && values.prec == head_.bits &&
            (values.sgnd != 0) == (head_.is_signed != 0));
  }

  // Signed values keep all bits.
  template <class T>
  std::string values() const {
    const std::size_t count = std::size_t{head_.columns} * head_.rows;
    std::string out(count * sizeof(T), '\0');
    const OPJ_INT32* const from = image_->comps[0].data;
    for (std::size_t i = 0; i < count; ++i) {
      const auto value = static_cast<T>(from[i]);
      std::memcpy(&out[i * sizeof(T)], &value, sizeof(T));
    }
    return out;
  }

  Jpeg2000Head head_;
  Bytes bytes_;
  std::unique_ptr<opj_stream_t, decltype(&opj_stream_destroy)> stream_;
  std::unique_ptr<opj_codec_t, decltype(&opj_destroy_codec)> codec_;
  std::unique_ptr<opj_image_t, decltype(&opj_image_destroy)> image_;
  std::string message_;
};

std::string decode(const std::string& request) {
  Jpeg2000Head head;
  if (request.size() < sizeof head) throw WorkerRefusal("a request that is cut short");
  std::memcpy(&head, request.data(), sizeof head);
  return Decoder(head, request.data() + sizeof head, request.size() - sizeof head).run();
}

}  // namespace

int main(int count, char** arguments) {
  const kiln::WorkerArguments limits = kiln::startWorker(count, arguments);
  kiln::serveRequests(limits, [](std::uint32_t, const std::string& payload) { return decode(payload); });
}
