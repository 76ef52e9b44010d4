// One frame of a demo, drawn through qcDevice_DrawPicture.
#include "common/bullet/demo_frame.h"

#include <algorithm>
#include <cmath>

namespace
{
constexpr float s_red[3] = {0.85f, 0.015f, 0.015f};

qcPictureMesh PictureMesh(const qcFrameMesh& mesh)
{
    qcPictureMesh picture{};
    picture.positions = mesh.positions;
    picture.vertexCount = mesh.vertexCount;
    picture.indices = mesh.indices;
    picture.triangleCount = mesh.triangleCount;
    picture.smooth = mesh.smooth;
    std::copy_n(mesh.color, 3, picture.color);
    std::copy_n(mesh.backColor, 3, picture.backColor);
    std::copy_n(s_red, 3, picture.markColor);
    return picture;
}

float Brightness(const float color[3])
{
    return 0.2126f * color[0] + 0.7152f * color[1] + 0.0722f * color[2];
}

/// Colours of the right half: greys, so that nothing but the PCS is red.
void MakeGrey(const qcFrameMesh& mesh, qcPictureMesh* picture)
{
    float front = 0.78f, back = 0.52f;
    if (mesh.isScenery)
    {
        front = Brightness(mesh.color);
        back = Brightness(mesh.backColor);
    }
    qcSet3(picture->color, front, front, front);
    qcSet3(picture->backColor, back, back, back);
    picture->marked = mesh.pcs;
}
} // namespace

void qcDemoFrame::Clear()
{
    m_meshes.clear();
    m_placed.clear();
}

const float* qcDemoFrame::Place(const btVector3* vertices, size_t count, const btTransform& place)
{
    m_placed.emplace_back(3 * count);
    float* positions = m_placed.back().data();
    for (size_t i = 0; i < count; i++)
    {
        btVector3 v = place * vertices[i];
        qcSet3(positions + 3 * i, float(v.x()), float(v.y()), float(v.z()));
    }
    return positions;
}

bool qcDemoFrame::Draw(qcDevice* device, bool showsPcs, uint32_t left, uint32_t imageWidth, std::string* message)
{
    m_pictureMeshes.clear();
    for (const qcFrameMesh& mesh : m_meshes)
    {
        m_pictureMeshes.push_back(PictureMesh(mesh));
        if (showsPcs)
            MakeGrey(mesh, &m_pictureMeshes.back());
    }
    qcPictureDef def = qcDefaultPictureDef();
    def.width = m_width;
    def.height = m_height;
    std::copy_n(camera.eye, 3, def.eye);
    std::copy_n(camera.target, 3, def.target);
    def.fieldOfView = camera.fieldOfView;
    std::copy_n(background, 3, def.background);
    std::copy_n(light, 3, def.light);
    def.hasGround = ground.isDrawn;
    def.groundHeight = ground.height;
    def.groundTile = ground.tile;
    def.groundExtent = ground.extent;
    std::copy_n(ground.color, 3, def.groundColor);
    def.meshes = m_pictureMeshes.data();
    def.meshCount = uint32_t(m_pictureMeshes.size());
    return qcDrawInto(device, def, &m_image, imageWidth, left, message);
}

bool qcDemoFrame::Write(qcDevice* device, const std::string& path, std::string* message)
{
    bool hasPcs =
        std::any_of(m_meshes.begin(), m_meshes.end(), [](const qcFrameMesh& mesh) { return mesh.pcs != nullptr; });
    uint32_t imageWidth = hasPcs ? 2 * m_width : m_width;
    return Draw(device, false, 0, imageWidth, message) &&
           (!hasPcs || Draw(device, true, m_width, imageWidth, message)) &&
           qcWritePng(path, m_image, imageWidth, m_height, message);
}

void qcPieceColor(size_t index, float color[3])
{
    double hue = std::fmod(0.08 + 0.618034 * double(index), 1.0);
    for (int i = 0; i < 3; i++)
        color[i] = float(0.42 + 0.20 * std::cos(6.2831853 * (hue - i / 3.0)));
}
