// Pictures of the demos of Bullet: shared meshes, drawing, and writing PNG files.
#ifndef QC_DEMOS_COMMON_BULLET_DEMO_PICTURE_H
#define QC_DEMOS_COMMON_BULLET_DEMO_PICTURE_H

#include "quickcullide/quickcullide.h"

#include <string>
#include <vector>

/// Three numbers: a colour, a position of the eye, and so on.
void qcSet3(float v[3], float x, float y, float z);

/// Adds a square in the plane y = 0, seen from above.
void qcAddFloor(float x, float z, float halfWidth, std::vector<float>* positions, std::vector<uint32_t>* indices);

/// A mesh with one colour on both sides.
qcPictureMesh qcPlainMesh(const std::vector<float>& positions, const std::vector<uint32_t>& indices, float r, float g,
                          float b);

/// Draws into the columns from `left` on of an image of `imageWidth` columns and def.height rows.
bool qcDrawInto(qcDevice* device, const qcPictureDef& def, std::vector<uint8_t>* image, uint32_t imageWidth,
                uint32_t left, std::string* message);

/// False with a message.
bool qcWritePng(const std::string& path, const std::vector<uint8_t>& image, uint32_t width, uint32_t height,
                std::string* message);

#endif
