/// @file
/// The C library, in the order in which data travels.
#ifndef QUICKCULLIDE_QUICKCULLIDE_H
#define QUICKCULLIDE_QUICKCULLIDE_H

#include "base.h"
#include "hash.h"
#include "device.h"
#include "scene.h"
#include "buffers.h"
#include "recording.h"
#include "boxes.h"

#endif
