// Frames of the breaking demo.
#include "breaking/picture.h"

namespace
{
/// A range of a shape's triangles in one colour.
void AddPart(const qcMeshShape& shape, const float* positions, uint32_t begin, uint32_t end, const float color[3],
             bool smooth, const std::vector<uint8_t>* marks, qcDemoFrame* frame)
{
    if (begin == end)
        return;
    qcFrameMesh mesh;
    mesh.positions = positions;
    mesh.vertexCount = shape.getVertexCount();
    mesh.indices = shape.getIndices() + 3 * size_t(begin);
    mesh.triangleCount = end - begin;
    mesh.smooth = smooth;
    mesh.pcs = marks != nullptr && !marks->empty() ? marks->data() + begin : nullptr;
    qcSet3(mesh.color, color[0], color[1], color[2]);
    qcSet3(mesh.backColor, color[0], color[1], color[2]);
    frame->Add(mesh);
}
} // namespace

qcBreakingPicture::qcBreakingPicture() : m_frame(800, 640)
{
    qcSet3(m_frame.camera.eye, 1.9f, 3.3f, 9.4f);
    qcSet3(m_frame.camera.target, 0.0f, 1.55f, 0.0f);
    m_frame.camera.fieldOfView = 36;
}

bool qcBreakingPicture::Write(qcDevice* device, const qcBreakingWorld& world, const qcBreakingMarks& marks,
                              const std::string& path, std::string* message)
{
    const float jade[3] = {0.36f, 0.50f, 0.40f}, inside[3] = {0.72f, 0.44f, 0.26f}, bunny[3] = {0.62f, 0.60f, 0.58f};
    const qcBreakingModel& model = world.Model();
    m_frame.Clear();
    for (uint32_t i = 0; i < model.shapes.size(); i++)
    {
        const qcMeshShape& shape = *model.shapes[i];
        const std::vector<uint8_t>* pieceMarks = marks.pieces.empty() ? nullptr : &marks.pieces[i];
        const float* positions = m_frame.Place(shape.getVertices(), shape.getVertexCount(), world.PiecePlace(i));
        uint32_t cut = model.fracture.pieces[i].firstCutTriangle;
        AddPart(shape, positions, 0, cut, jade, true, pieceMarks, &m_frame);
        AddPart(shape, positions, cut, shape.getTriangleCount(), inside, false, pieceMarks, &m_frame);
    }
    const qcMeshShape& shape = *model.bunny.shape;
    AddPart(shape, m_frame.Place(shape.getVertices(), shape.getVertexCount(), world.BunnyPlace()), 0,
            shape.getTriangleCount(), bunny, true, &marks.bunny, &m_frame);
    return m_frame.Write(device, path, message);
}
