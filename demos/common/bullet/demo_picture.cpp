// Pictures of the demos of Bullet.
#include "common/bullet/demo_picture.h"

#include "common/png_file.h"

#include <cstring>

void qcSet3(float v[3], float x, float y, float z)
{
    v[0] = x;
    v[1] = y;
    v[2] = z;
}

void qcAddFloor(float x, float z, float halfWidth, std::vector<float>* positions, std::vector<uint32_t>* indices)
{
    auto corner = uint32_t(positions->size() / 3);
    float w = halfWidth;
    positions->insert(positions->end(), {x - w, 0, z - w, x + w, 0, z - w, x + w, 0, z + w, x - w, 0, z + w});
    indices->insert(indices->end(), {corner, corner + 2, corner + 1, corner, corner + 3, corner + 2});
}

qcPictureMesh qcPlainMesh(const std::vector<float>& positions, const std::vector<uint32_t>& indices, float r, float g,
                          float b)
{
    qcPictureMesh mesh{};
    mesh.positions = positions.data();
    mesh.vertexCount = uint32_t(positions.size() / 3);
    mesh.indices = indices.data();
    mesh.triangleCount = uint32_t(indices.size() / 3);
    qcSet3(mesh.color, r, g, b);
    qcSet3(mesh.backColor, r, g, b);
    return mesh;
}

bool qcDrawInto(qcDevice* device, const qcPictureDef& def, std::vector<uint8_t>* image, uint32_t imageWidth,
                uint32_t left, std::string* message)
{
    std::vector<uint8_t> drawn(size_t(def.width) * def.height * 3);
    if (qcDevice_DrawPicture(device, &def, drawn.data()) != qc_statusOk)
    {
        *message = qcLastMessage();
        return false;
    }
    image->resize(size_t(imageWidth) * def.height * 3);
    for (uint32_t row = 0; row < def.height; row++)
        std::memcpy(&(*image)[(size_t(row) * imageWidth + left) * 3], &drawn[size_t(row) * def.width * 3],
                    size_t(def.width) * 3);
    return true;
}

bool qcWritePng(const std::string& path, const std::vector<uint8_t>& image, uint32_t width, uint32_t height,
                std::string* message)
{
    qcMessage failure;
    if (qcPng_Write(path.c_str(), width, height, image.data(), &failure))
        return true;
    *message = failure.text;
    return false;
}
