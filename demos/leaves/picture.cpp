// Frames of the leaves demo, after figure 6 of the paper.
#include "leaves/picture.h"

#include <iterator>

namespace
{
// Green and yellow to red and brown; each leaf has one of them, a little lighter or darker. Linear RGB.
constexpr float s_autumn[][3] = {{0.62f, 0.10f, 0.03f}, {0.75f, 0.22f, 0.03f}, {0.82f, 0.36f, 0.04f},
                                 {0.80f, 0.52f, 0.06f}, {0.46f, 0.05f, 0.04f}, {0.44f, 0.40f, 0.07f},
                                 {0.30f, 0.13f, 0.05f}, {0.70f, 0.30f, 0.05f}};

/// Independent of all other leaves.
void SetAutumnColor(size_t leaf, qcFrameMesh* mesh)
{
    auto hash = uint32_t(leaf + 1) * 2654435761u;
    const float* color = s_autumn[(hash >> 20) % std::size(s_autumn)];
    float light = 0.80f + 0.40f * float((hash >> 8) & 0xff) / 255;
    qcSet3(mesh->color, color[0] * light, color[1] * light, color[2] * light);
    // The lower side is paler.
    qcSet3(mesh->backColor, 0.75f * color[0] * light + 0.08f, 0.75f * color[1] * light + 0.07f,
           0.75f * color[2] * light + 0.04f);
}
} // namespace

qcLeavesPicture::qcLeavesPicture(const qcLeavesWorld& world) : m_frame(800, 720), m_positions(world.LeafCount())
{
    for (const btVector3& vertex : world.Tree().vertices)
        m_treePositions.insert(m_treePositions.end(), {float(vertex.x()), float(vertex.y()), float(vertex.z())});
    qcSet3(m_frame.camera.eye, 1.2f, 2.0f, 6.6f);
    qcSet3(m_frame.camera.target, 0.35f, 1.27f, 0.0f);
    m_frame.camera.fieldOfView = 31;
    // Contact holds most leaves 9 mm above the ground; they seem to float unless it is drawn higher.
    m_frame.ground.height = 0.004f;
    qcSet3(m_frame.ground.color, 0.33f, 0.38f, 0.22f);
    qcSet3(m_frame.background, 0.72f, 0.80f, 0.86f);
}

bool qcLeavesPicture::Write(qcDevice* device, const qcLeavesWorld& world, const qcLeavesMarks& marks,
                            const std::string& path, std::string* message)
{
    m_frame.Clear();
    qcFrameMesh tree;
    tree.SetTriangles(m_treePositions, world.Tree().indices);
    tree.smooth = true;
    qcSet3(tree.color, 0.16f, 0.11f, 0.075f);
    qcSet3(tree.backColor, 0.16f, 0.11f, 0.075f);
    tree.pcs = marks.tree.data();
    m_frame.Add(tree);
    for (size_t i = 0; i < world.LeafCount(); i++)
    {
        m_positions[i].clear();
        world.AppendPositions(i, 0, &m_positions[i]);
        qcFrameMesh leaf;
        leaf.SetTriangles(m_positions[i], world.LeafIndices());
        SetAutumnColor(i, &leaf);
        leaf.pcs = marks.leaves[i].data();
        m_frame.Add(leaf);
    }
    return m_frame.Write(device, path, message);
}
