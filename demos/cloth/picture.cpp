// Frames of the cloth demo, after figure 4 of the paper.
#include "cloth/picture.h"

#include "cloth/world.h"
#include "common/bullet/demo_picture.h"

#include <cmath>

namespace
{
constexpr uint32_t s_halfWidth = 800, s_height = 640;

/// A closed cylinder around the y axis.
void AddCylinder(float radius, float bottom, float top, std::vector<float>* positions, std::vector<uint32_t>* indices)
{
    constexpr uint32_t segments = 64;
    auto first = uint32_t(positions->size() / 3);
    for (uint32_t i = 0; i < segments; i++)
    {
        float angle = 6.2831853f * float(i) / segments;
        for (float y : {bottom, top})
            positions->insert(positions->end(), {radius * std::cos(angle), y, radius * std::sin(angle)});
    }
    for (uint32_t i = 0; i < segments; i++)
    {
        uint32_t a = first + 2 * i, b = first + 2 * ((i + 1) % segments);
        indices->insert(indices->end(), {a, a + 1, b, b, a + 1, b + 1});
        if (i >= 1 && i + 1 < segments)
            indices->insert(indices->end(), {first, a, b, first + 1, b + 1, a + 1});
    }
}
} // namespace

qcClothPicture::qcClothPicture()
{
    // Bullet keeps the nodes of a soft body off the table, not the faces between them, which cut across its rim.
    constexpr float inset = 0.015f;
    constexpr float bottom = qcClothTable::height - qcClothTable::thickness;
    AddCylinder(qcClothTable::radius - inset, bottom, qcClothTable::height - inset, &m_furniturePositions,
                &m_tableIndices);
    AddCylinder(0.05f, 0.0f, bottom, &m_furniturePositions, &m_tableIndices);
    qcAddFloor(0, 0, 40, &m_furniturePositions, &m_floorIndices);
}

bool qcClothPicture::Draw(qcDevice* device, const qcPictureMesh& cloth, uint32_t left, std::string* message)
{
    qcPictureMesh floor = qcPlainMesh(m_furniturePositions, m_floorIndices, 0.62f, 0.63f, 0.64f);
    qcPictureMesh table = qcPlainMesh(m_furniturePositions, m_tableIndices, 0.30f, 0.17f, 0.09f);
    const qcPictureMesh meshes[] = {floor, table, cloth};

    qcPictureDef def = qcDefaultPictureDef();
    def.width = s_halfWidth;
    def.height = s_height;
    qcSet3(def.eye, 1.7f, 1.75f, 2.25f);
    qcSet3(def.target, 0.05f, 0.34f, 0.0f);
    def.fieldOfView = 32.0f;
    def.meshes = meshes;
    def.meshCount = 3;
    return qcDrawInto(device, def, &m_image, m_width, left, message);
}

bool qcClothPicture::Write(qcDevice* device, const std::vector<float>& positions, const std::vector<uint32_t>& indices,
                           const std::vector<uint8_t>& marked, const std::string& path, std::string* message)
{
    m_width = marked.empty() ? s_halfWidth : 2 * s_halfWidth;
    qcPictureMesh cloth = qcPlainMesh(positions, indices, 0.70f, 0.42f, 0.16f);
    cloth.smooth = true;
    qcSet3(cloth.backColor, 0.10f, 0.28f, 0.55f);
    if (!Draw(device, cloth, 0, message))
        return false;
    if (!marked.empty())
    {
        qcSet3(cloth.color, 0.52f, 0.52f, 0.50f);
        qcSet3(cloth.backColor, 0.66f, 0.66f, 0.62f);
        qcSet3(cloth.markColor, 0.80f, 0.02f, 0.02f);
        cloth.marked = marked.data();
        if (!Draw(device, cloth, s_halfWidth, message))
            return false;
    }
    return qcWritePng(path, m_image, m_width, s_height, message);
}
