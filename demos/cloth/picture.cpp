// Frames of the cloth demo, after figure 4 of the paper.
#include "cloth/picture.h"

#include "cloth/world.h"
#include "common/bullet/demo_frame.h"

#include <cmath>

namespace
{
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

/// A box, its faces seen from outside.
void AddBox(const btVector3& middle, const btVector3& half, std::vector<float>* positions,
            std::vector<uint32_t>* indices)
{
    for (int corner = 0; corner < 8; corner++)
        for (int axis = 0; axis < 3; axis++)
            positions->push_back(float(middle[axis] + (corner >> axis & 1 ? half[axis] : -half[axis])));
    indices->insert(indices->end(), {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                                     2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6});
}

/// From `a` at 0 to `b` at 1.
void Blend(const float a[3], const float b[3], float part, float result[3])
{
    for (int i = 0; i < 3; i++)
        result[i] = a[i] + part * (b[i] - a[i]);
}
} // namespace

qcClothPicture::qcClothPicture() : m_frame(800, 640)
{
    // Bullet keeps the nodes of a soft body off the table, not the faces between them, which cut across its rim.
    constexpr float inset = 0.015f;
    constexpr float bottom = qcClothTable::height - qcClothTable::thickness;
    AddCylinder(qcClothTable::radius - inset, bottom, qcClothTable::height - inset, &m_tablePositions, &m_tableIndices);
    AddCylinder(0.05f, 0.0f, bottom, &m_tablePositions, &m_tableIndices);
    m_frame.camera.fieldOfView = 32;
    Follow(0);
}

void qcClothPicture::Follow(float part)
{
    const float eyes[2][3] = {{1.7f, 1.75f, 2.25f}, {2.85f, 2.25f, 4.0f}};
    const float targets[2][3] = {{0.05f, 0.34f, 0.0f}, {1.5f, 0.25f, 0.0f}};
    float smooth = part * part * (3 - 2 * part);
    Blend(eyes[0], eyes[1], smooth, m_frame.camera.eye);
    Blend(targets[0], targets[1], smooth, m_frame.camera.target);
}

void qcClothPicture::SetGrip(const btVector3* middle)
{
    m_gripPositions.clear();
    m_gripIndices.clear();
    if (middle != nullptr)
        AddBox(*middle, btVector3(qcClothWorld::gripHalf, qcClothWorld::gripHalf, qcClothWorld::gripHalfLength),
               &m_gripPositions, &m_gripIndices);
}

bool qcClothPicture::Write(qcDevice* device, const std::vector<float>& positions, const std::vector<uint32_t>& indices,
                           const std::vector<uint8_t>& marked, const std::string& path, std::string* message)
{
    m_frame.Clear();
    qcFrameMesh table;
    table.SetTriangles(m_tablePositions, m_tableIndices);
    table.isScenery = true;
    qcSet3(table.color, 0.30f, 0.17f, 0.09f);
    qcSet3(table.backColor, 0.30f, 0.17f, 0.09f);
    m_frame.Add(table);
    qcFrameMesh grip = table;
    grip.SetTriangles(m_gripPositions, m_gripIndices);
    m_frame.Add(grip);

    qcFrameMesh cloth;
    cloth.SetTriangles(positions, indices);
    cloth.smooth = true;
    qcSet3(cloth.color, 0.70f, 0.42f, 0.16f);
    qcSet3(cloth.backColor, 0.10f, 0.28f, 0.55f);
    cloth.pcs = marked.empty() ? nullptr : marked.data();
    m_frame.Add(cloth);
    return m_frame.Write(device, path, message);
}
