// Frames of the cloth demo, after figure 4 of the paper.
#include "cloth_picture.h"

#include "cloth_world.h"

extern "C" {
#include "png_file.h"
}

#include <cmath>
#include <cstring>

namespace
{
constexpr uint32_t s_halfWidth = 800, s_height = 640;

void SetColor(float color[3], float r, float g, float b)
{
    color[0] = r;
    color[1] = g;
    color[2] = b;
}

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
    // Bullet keeps the nodes of a soft body off the table, not the faces between them: these cut across its rim.
    constexpr float inset = 0.015f;
    constexpr float bottom = qcClothTable::height - qcClothTable::thickness;
    AddCylinder(qcClothTable::radius - inset, bottom, qcClothTable::height - inset, &m_furniturePositions,
                &m_tableIndices);
    AddCylinder(0.05f, 0.0f, bottom, &m_furniturePositions, &m_tableIndices);
    auto corner = uint32_t(m_furniturePositions.size() / 3);
    const float floor[] = {-40, 0, -40, 40, 0, -40, 40, 0, 40, -40, 0, 40};
    m_furniturePositions.insert(m_furniturePositions.end(), std::begin(floor), std::end(floor));
    m_floorIndices = {corner, corner + 2, corner + 1, corner, corner + 3, corner + 2};
}

bool qcClothPicture::Draw(qcDevice* device, const qcPictureMesh& cloth, uint32_t left, std::string* message)
{
    qcPictureMesh table{};
    table.positions = m_furniturePositions.data();
    table.vertexCount = uint32_t(m_furniturePositions.size() / 3);
    table.indices = m_tableIndices.data();
    table.triangleCount = uint32_t(m_tableIndices.size() / 3);
    SetColor(table.color, 0.30f, 0.17f, 0.09f);
    SetColor(table.backColor, 0.30f, 0.17f, 0.09f);
    qcPictureMesh floor = table;
    floor.indices = m_floorIndices.data();
    floor.triangleCount = uint32_t(m_floorIndices.size() / 3);
    SetColor(floor.color, 0.62f, 0.63f, 0.64f);
    SetColor(floor.backColor, 0.62f, 0.63f, 0.64f);
    const qcPictureMesh meshes[] = {floor, table, cloth};

    qcPictureDef def = qcDefaultPictureDef();
    def.width = s_halfWidth;
    def.height = s_height;
    SetColor(def.eye, 1.7f, 1.75f, 2.25f);
    SetColor(def.target, 0.05f, 0.34f, 0.0f);
    def.fieldOfView = 32.0f;
    def.meshes = meshes;
    def.meshCount = 3;
    m_half.resize(size_t(s_halfWidth) * s_height * 3);
    if (qcDevice_DrawPicture(device, &def, m_half.data()) != qc_statusOk)
    {
        *message = qcLastMessage();
        return false;
    }
    for (uint32_t row = 0; row < s_height; row++)
        std::memcpy(&m_image[(size_t(row) * m_width + left) * 3], &m_half[size_t(row) * s_halfWidth * 3],
                    size_t(s_halfWidth) * 3);
    return true;
}

bool qcClothPicture::Write(qcDevice* device, const std::vector<float>& positions, const std::vector<uint32_t>& indices,
                           const std::vector<uint8_t>& marked, const std::string& path, std::string* message)
{
    m_width = marked.empty() ? s_halfWidth : 2 * s_halfWidth;
    m_image.assign(size_t(m_width) * s_height * 3, 0);
    qcPictureMesh cloth{};
    cloth.positions = positions.data();
    cloth.vertexCount = uint32_t(positions.size() / 3);
    cloth.indices = indices.data();
    cloth.triangleCount = uint32_t(indices.size() / 3);
    cloth.smooth = true;
    SetColor(cloth.color, 0.70f, 0.42f, 0.16f);
    SetColor(cloth.backColor, 0.10f, 0.28f, 0.55f);
    if (!Draw(device, cloth, 0, message))
        return false;
    if (!marked.empty())
    {
        SetColor(cloth.color, 0.52f, 0.52f, 0.50f);
        SetColor(cloth.backColor, 0.66f, 0.66f, 0.62f);
        SetColor(cloth.markColor, 0.80f, 0.02f, 0.02f);
        cloth.marked = marked.data();
        if (!Draw(device, cloth, s_halfWidth, message))
            return false;
    }
    qcMessage failure;
    if (qcPng_Write(path.c_str(), m_width, s_height, m_image.data(), &failure))
        return true;
    *message = failure.text;
    return false;
}
