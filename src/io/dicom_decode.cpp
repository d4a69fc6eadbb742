/* SPDX-License-Identifier: MIT */
/* JPEG, JPEG-LS and JPEG 2000 inside of DICOM, unpacked by GDCM: the only place that knows GDCM, and the only C++ of the library.
 *
 * GDCM gets one frame's bytes and what the header says of it, not the file. Its codecs believe the sizes inside of the compressed bytes, so those
 * are looked up first and held against the header. */
#include <cstring>
#include <exception>
#include <sstream>

#include <gdcmDataElement.h>
#include <gdcmFragment.h>
#include <gdcmImageCodec.h>
#include <gdcmJPEG2000Codec.h>
#include <gdcmJPEGCodec.h>
#include <gdcmJPEGLSCodec.h>
#include <gdcmSequenceOfFragments.h>
#include <gdcmTrace.h>
#include <gdcmTransferSyntax.h>

#include "dicom_file.h"

extern "C" {
#include "fail.h"
}

namespace {

unsigned number16(const unsigned char *p)
{
    return unsigned(p[0]) << 8 | p[1];
}

unsigned long number32(const unsigned char *p)
{
    return (unsigned long)number16(p) << 16 | number16(p + 2);
}

/* The size that is written into a JPEG or JPEG-LS stream (SOF marker). False where there is none. */
bool jpeg_size(const unsigned char *bytes, size_t size, unsigned long &columns, unsigned long &rows, int &bits, int &samples)
{
    if (size < 4 || bytes[0] != 0xff || bytes[1] != 0xd8)
        return false;
    for (size_t at = 2; at + 4 <= size;) {
        unsigned marker = bytes[at + 1], length = number16(bytes + at + 2);
        if (bytes[at] != 0xff)
            return false;
        if (marker == 0xff) {
            at++;
            continue;
        }
        bool frame = (marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc) || marker == 0xf7;
        if (frame && at + 10 <= size) {
            bits = bytes[at + 4];
            rows = number16(bytes + at + 5);
            columns = number16(bytes + at + 7);
            samples = bytes[at + 9];
            return true;
        }
        if (marker == 0xda || length < 2)
            return false;
        at += 2 + length;
    }
    return false;
}

/* The size that is written into a JPEG 2000 stream (SIZ marker), bare or in a JP2 box. */
bool jpeg2000_size(const unsigned char *bytes, size_t size, unsigned long &columns, unsigned long &rows, int &bits, int &samples)
{
    for (size_t at = 0; at + 43 <= size && at < 4096; at++)
        if (bytes[at] == 0xff && bytes[at + 1] == 0x4f && bytes[at + 2] == 0xff && bytes[at + 3] == 0x51) {
            const unsigned char *p = bytes + at + 8;
            unsigned long x1 = number32(p), y1 = number32(p + 4), x0 = number32(p + 8), y0 = number32(p + 12);
            unsigned long tile_x = number32(p + 16), tile_y = number32(p + 20);
            if (x1 <= x0 || y1 <= y0 || !tile_x || !tile_y)
                return false;
            columns = x1 - x0;
            rows = y1 - y0;
            samples = int(number16(p + 32));
            bits = (p[34] & 0x7f) + 1;
            return x0 == 0 && y0 == 0;
        }
    return false;
}

bool decode(gdcm::ImageCodec &codec, const gdcm::TransferSyntax &syntax, const struct pel_dicom_pixels &pixels, const unsigned char *bytes,
            size_t size, void *out, size_t out_size, struct pel_error *error)
{
    if (!codec.CanDecode(syntax))
        return pel_fail(error, PEL_ERROR_UNSUPPORTED, "this kind of compression is not read");
    const unsigned dims[3] = { pixels.columns, pixels.rows, 1 };
    codec.SetNumberOfDimensions(2);
    codec.SetDimensions(dims);
    codec.SetPlanarConfiguration(0);
    codec.SetPixelFormat(gdcm::PixelFormat((unsigned short)pixels.samples, (unsigned short)pixels.allocated, (unsigned short)pixels.stored,
                                           (unsigned short)pixels.high_bit, pixels.is_signed));
    codec.SetPhotometricInterpretation(pixels.samples == 3 ? gdcm::PhotometricInterpretation::RGB
                                                           : gdcm::PhotometricInterpretation::MONOCHROME2);
    codec.SetNeedOverlayCleanup(false);
    gdcm::Fragment fragment;
    fragment.SetByteValue((const char *)bytes, gdcm::VL((unsigned)size));
    gdcm::SmartPointer<gdcm::SequenceOfFragments> sequence = new gdcm::SequenceOfFragments;
    sequence->AddFragment(fragment);
    gdcm::DataElement in(gdcm::Tag(0x7fe0, 0x0010), gdcm::VL::GetVL32Max(), gdcm::VR::OB), unpacked;
    in.SetValue(*sequence);
    if (!codec.Decode(in, unpacked) || !unpacked.GetByteValue())
        return pel_fail(error, PEL_ERROR_FORMAT, "the compressed pixels are damaged");
    const gdcm::ByteValue *value = unpacked.GetByteValue();
    size_t length = value->GetLength();
    if (length != out_size && length != out_size + 1) /* GDCM makes lengths even */
        return pel_fail(error, PEL_ERROR_FORMAT, "the compressed pixels unpack to %zu bytes, not %zu", length, out_size);
    std::memcpy(out, value->GetPointer(), out_size);
    return true;
}

} // namespace

bool pel_dicom_decode(const char *syntax, const struct pel_dicom_pixels *pixels, const unsigned char *bytes, size_t size, void *out,
                      size_t out_size, struct pel_error *error)
{
    try {
        unsigned long columns = 0, rows = 0;
        int bits = 0, samples = 0;
        gdcm::TransferSyntax type(gdcm::TransferSyntax::GetTSType(syntax));
        gdcm::JPEG2000Codec jpeg2000;
        gdcm::JPEGLSCodec jpegls;
        gdcm::JPEGCodec jpeg;
        bool is_2000 = jpeg2000.CanDecode(type), is_ls = jpegls.CanDecode(type), is_jpeg = jpeg.CanDecode(type);
        if (!is_2000 && !is_ls && !is_jpeg)
            return pel_fail(error, PEL_ERROR_UNSUPPORTED, "transfer syntax %s is not read; convert it, for example with gdcmconv --raw", syntax);
        if (size > 0xfffffff0u || !(is_2000 ? jpeg2000_size : jpeg_size)(bytes, size, columns, rows, bits, samples))
            return pel_fail(error, PEL_ERROR_FORMAT, "the compressed pixels do not begin as they should");
        if (columns != pixels->columns || rows != pixels->rows || samples != pixels->samples || bits > pixels->allocated ||
            (bits + 7) / 8 != pixels->allocated / 8)
            return pel_fail(error, PEL_ERROR_FORMAT, "the compressed pixels are %lu x %lu of %d x %d bits, the header says %u x %u of %d x %d",
                            columns, rows, samples, bits, pixels->columns, pixels->rows, pixels->samples, pixels->allocated);
        gdcm::Trace::WarningOff(); /* GDCM tells on the terminal what we tell in the error */
        gdcm::Trace::DebugOff();
        gdcm::Trace::ErrorOff();
        gdcm::ImageCodec &codec = is_2000 ? static_cast<gdcm::ImageCodec &>(jpeg2000) : is_ls ? static_cast<gdcm::ImageCodec &>(jpegls) : jpeg;
        return decode(codec, type, *pixels, bytes, size, out, out_size, error);
    } catch (const std::bad_alloc &) {
        return pel_fail(error, PEL_ERROR_MEMORY, "no memory for unpacking pixels");
    } catch (const std::exception &problem) {
        return pel_fail(error, PEL_ERROR_FORMAT, "the compressed pixels cannot be unpacked: %.200s", problem.what());
    } catch (...) {
        return pel_fail(error, PEL_ERROR_FORMAT, "the compressed pixels cannot be unpacked");
    }
}
