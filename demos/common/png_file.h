// Writes a picture as a PNG file.
#ifndef QC_DEMOS_COMMON_PNG_FILE_H
#define QC_DEMOS_COMMON_PNG_FILE_H

#include "common/message.h"

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// `rgb` holds width * height * 3 bytes, sRGB, top row first. The file appears when it is complete; on failure an
/// old one stays, and the message names the path.
bool qcPng_Write(const char* path, uint32_t width, uint32_t height, const uint8_t* rgb, qcMessage* message);

#ifdef __cplusplus
}
#endif

#endif
