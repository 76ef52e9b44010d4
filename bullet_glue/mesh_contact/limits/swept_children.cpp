// The meshes and cores of a compound that stays in a step, with boxes around them.
#include "mesh_contact/limits/swept_children.h"

#include "common/compound_children.h"
#include "common/shape_triangles.h"

#include <algorithm>

void qcSweptChildren::Clear()
{
    m_children.clear();
    m_blocks.clear();
    m_meshCount = 0;
    m_radius = 0;
    m_areRead = false;
    m_areAll = true;
}

void qcSweptChildren::Add(const Child& child)
{
    const size_t lane = m_children.size() % s_width;
    if (lane == 0)
    {
        m_blocks.emplace_back();
        std::fill_n(m_blocks.back().lower[0], 3 * s_width, BT_LARGE_FLOAT);
        std::fill_n(m_blocks.back().upper[0], 3 * s_width, -BT_LARGE_FLOAT);
    }
    m_children.push_back(child);
    btVector3 lower, upper;
    child.mesh->getAabb(child.local, lower, upper);
    for (int axis = 0; axis < 3; axis++)
    {
        m_blocks.back().lower[axis][lane] = lower[axis];
        m_blocks.back().upper[axis][lane] = upper[axis];
    }
    btVector3 far = lower.absolute();
    far.setMax(upper.absolute());
    m_radius = std::max(m_radius, far.length());
}

void qcSweptChildren::Read(const btCollisionShape* compound, qcConvexCores* cores)
{
    Clear();
    m_areRead = true;
    auto addMesh = [this](const btCollisionShape* shape, const btTransform& local)
    {
        const qcMeshShape* mesh = qcAsMeshShape(shape);
        if (mesh != nullptr)
            Add({mesh, nullptr, nullptr, local});
        else
            m_areAll = m_areAll && !qcIsMesh(shape);
    };
    qcForEachSimpleShape(compound, btTransform::getIdentity(), addMesh);
    m_meshCount = m_children.size();
    auto addCore = [this](const qcConvexCore& core, const btTransform& local) {
        Add({core.mesh.get(), core.shape, core.hull.get(), local});
    };
    if (cores != nullptr)
        cores->ForEachCore(compound, addCore);
}
