// Writes a picture as a PNG file, through libpng's simplified interface.
#include "common/png_file.h"

#include "common/output_file.h"

#include <errno.h>
#include <png.h>
#include <string.h>

bool qcPng_Write(const char* path, uint32_t width, uint32_t height, const uint8_t* rgb, qcMessage* message)
{
    qcOutput output;
    if (!qcOutput_Open(path, &output, message))
        return false;
    png_image image;
    memset(&image, 0, sizeof image);
    image.version = PNG_IMAGE_VERSION;
    image.width = width;
    image.height = height;
    image.format = PNG_FORMAT_RGB;
    errno = 0;
    if (!png_image_write_to_stdio(&image, output.stream, 0, rgb, 0, NULL))
    {
        // The reason is more than "Write Error" of libpng.
        qcMessage_Fail(message, "%s: %s", path, errno != 0 ? strerror(errno) : image.message);
        png_image_free(&image);
        qcOutput_Abort(&output);
        return false;
    }
    return qcOutput_Commit(&output, message);
}
