// Frames of the fracture demo.
#include "fracture/picture.h"

namespace
{
/// Outside and cuts of a body: meshes over the same vertices. Both sides of a cut have one colour.
void AddMeshes(const qcFractureBody& body, const float color[3], qcDemoFrame* frame)
{
    const qcMeshShape& shape = body.shape;
    qcFrameMesh outside;
    outside.positions = frame->Place(shape.getVertices(), shape.getVertexCount(), body.body.getWorldTransform());
    outside.vertexCount = shape.getVertexCount();
    outside.indices = shape.getIndices();
    outside.triangleCount = body.firstCutTriangle;
    outside.smooth = true;
    qcSet3(outside.color, color[0], color[1], color[2]);
    qcSet3(outside.backColor, color[0], color[1], color[2]);
    if (outside.triangleCount > 0)
        frame->Add(outside);
    // Triangles of one cut follow each other.
    for (size_t begin = 0, end; begin < body.cuts.size(); begin = end)
    {
        for (end = begin; end < body.cuts.size() && body.cuts[end] == body.cuts[begin]; end++)
            continue;
        qcFrameMesh cut = outside;
        cut.indices += 3 * (size_t(body.firstCutTriangle) + begin);
        cut.triangleCount = uint32_t(end - begin);
        cut.smooth = false;
        qcPieceColor(body.cuts[begin], cut.color);
        for (int i = 0; i < 3; i++)
            cut.backColor[i] = cut.color[i] *= 0.55f;
        frame->Add(cut);
    }
}
} // namespace

qcFracturePicture::qcFracturePicture() : m_frame(960, 640)
{
    qcSet3(m_frame.camera.eye, 3.4f, 3.9f, 11.3f);
    qcSet3(m_frame.camera.target, 0.1f, 1.75f, 0.0f);
    m_frame.camera.fieldOfView = 39;
    m_frame.ground.tile = 1;
}

bool qcFracturePicture::Write(qcDevice* device, const std::vector<std::unique_ptr<qcFractureBody>>& bodies,
                              const std::string& path, std::string* message)
{
    m_frame.Clear();
    for (size_t i = 0; i < bodies.size(); i++)
    {
        float color[3] = {0.62f, 0.55f, 0.45f};
        if (bodies.size() > 1)
            qcPieceColor(i, color);
        AddMeshes(*bodies[i], color, &m_frame);
    }
    return m_frame.Write(device, path, message);
}
