// Frames of the fracture demo.
#include "fracture/picture.h"

#include "common/bullet/demo_picture.h"

#include <cmath>

namespace
{
constexpr uint32_t s_width = 960, s_height = 640;
constexpr float s_tile = 0.5f; // half a tile, m
constexpr int s_tiles = 60;    // from the middle to the edge

/// In world space.
std::vector<float> PlacedVertices(const qcFractureBody& body)
{
    const btTransform& place = body.body.getWorldTransform();
    std::vector<float> positions;
    positions.reserve(3 * size_t(body.shape.getVertexCount()));
    for (uint32_t i = 0; i < body.shape.getVertexCount(); i++)
    {
        btVector3 v = place * body.shape.getVertices()[i];
        positions.insert(positions.end(), {float(v.x()), float(v.y()), float(v.z())});
    }
    return positions;
}

/// Colours that neighbours in the list don't share: hues a golden section apart, none of them strong.
void PieceColor(size_t index, float color[3])
{
    double hue = std::fmod(0.08 + 0.618034 * double(index), 1.0);
    for (int i = 0; i < 3; i++)
        color[i] = float(0.42 + 0.20 * std::cos(6.2831853 * (hue - i / 3.0)));
}

/// Outside and cuts of a body: two meshes over the same vertices.
void AddMeshes(const qcFractureBody& body, const std::vector<float>& positions, const float color[3],
               std::vector<qcPictureMesh>* meshes)
{
    qcPictureMesh outside{};
    outside.positions = positions.data();
    outside.vertexCount = uint32_t(positions.size() / 3);
    outside.indices = body.shape.getIndices();
    outside.triangleCount = body.firstCutTriangle;
    outside.smooth = true;
    qcSet3(outside.color, color[0], color[1], color[2]);
    qcSet3(outside.backColor, color[0], color[1], color[2]);
    qcPictureMesh cuts = outside;
    cuts.indices += 3 * size_t(body.firstCutTriangle);
    cuts.triangleCount = body.shape.getTriangleCount() - body.firstCutTriangle;
    cuts.smooth = false;
    for (float* part : {cuts.color, cuts.backColor})
        for (int i = 0; i < 3; i++)
            part[i] *= 0.45f;
    if (outside.triangleCount > 0)
        meshes->push_back(outside);
    if (cuts.triangleCount > 0)
        meshes->push_back(cuts);
}
} // namespace

qcFracturePicture::qcFracturePicture()
{
    for (int x = -s_tiles; x < s_tiles; x++)
        for (int z = -s_tiles; z < s_tiles; z++)
            qcAddFloor(float(2 * x + 1) * s_tile, float(2 * z + 1) * s_tile, s_tile, &m_floor,
                       (x + z) % 2 == 0 ? &m_lightTiles : &m_darkTiles);
}

bool qcFracturePicture::Write(qcDevice* device, const std::vector<std::unique_ptr<qcFractureBody>>& bodies,
                              const std::string& path, std::string* message)
{
    std::vector<qcPictureMesh> meshes = {qcPlainMesh(m_floor, m_lightTiles, 0.62f, 0.63f, 0.64f),
                                         qcPlainMesh(m_floor, m_darkTiles, 0.50f, 0.51f, 0.53f)};
    std::vector<std::vector<float>> positions;
    positions.reserve(bodies.size());
    for (size_t i = 0; i < bodies.size(); i++)
    {
        float color[3] = {0.62f, 0.55f, 0.45f};
        if (bodies.size() > 1)
            PieceColor(i, color);
        positions.push_back(PlacedVertices(*bodies[i]));
        AddMeshes(*bodies[i], positions.back(), color, &meshes);
    }
    qcPictureDef def = qcDefaultPictureDef();
    def.width = s_width;
    def.height = s_height;
    qcSet3(def.eye, 3.4f, 3.9f, 11.3f);
    qcSet3(def.target, 0.1f, 1.0f, 0.0f);
    def.fieldOfView = 36.0f;
    def.meshes = meshes.data();
    def.meshCount = uint32_t(meshes.size());
    std::vector<uint8_t> image;
    return qcDrawInto(device, def, &image, s_width, 0, message) && qcWritePng(path, image, s_width, s_height, message);
}
