// The meshes of a compound that stays in a step, with boxes around them.
#include "mesh_contact/limits/swept_children.h"

#include "common/compound_children.h"
#include "common/shape_triangles.h"

#include <algorithm>

void qcSweptChildren::Clear()
{
    m_children.clear();
    m_blocks.clear();
    m_radius = 0;
    m_areRead = false;
    m_areMeshes = true;
}

void qcSweptChildren::Add(const btCollisionShape* shape, const btTransform& local)
{
    const qcMeshShape* mesh = qcAsMeshShape(shape);
    m_areMeshes = m_areMeshes && mesh != nullptr;
    if (!m_areMeshes)
        return;
    const size_t lane = m_children.size() % s_width;
    if (lane == 0)
    {
        m_blocks.emplace_back();
        std::fill_n(m_blocks.back().lower[0], 3 * s_width, BT_LARGE_FLOAT);
        std::fill_n(m_blocks.back().upper[0], 3 * s_width, -BT_LARGE_FLOAT);
    }
    m_children.push_back({mesh, local});
    btVector3 lower, upper;
    mesh->getAabb(local, lower, upper);
    for (int axis = 0; axis < 3; axis++)
    {
        m_blocks.back().lower[axis][lane] = lower[axis];
        m_blocks.back().upper[axis][lane] = upper[axis];
    }
    btVector3 far = lower.absolute();
    far.setMax(upper.absolute());
    m_radius = std::max(m_radius, far.length());
}

void qcSweptChildren::Read(const btCollisionShape* compound)
{
    Clear();
    m_areRead = true;
    qcForEachSimpleShape(compound, btTransform::getIdentity(),
                         [this](const btCollisionShape* shape, const btTransform& local) { Add(shape, local); });
}
