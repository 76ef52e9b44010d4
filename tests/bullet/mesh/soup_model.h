// Soups of triangles as models.
#ifndef QC_TESTS_BULLET_MESH_SOUP_MODEL_H
#define QC_TESTS_BULLET_MESH_SOUP_MODEL_H

#include "bullet/mesh/mesh_models.h"
#include "support/soups.h"

/// Frees the soup.
inline qcModel qcModelOf(qcSoup soup)
{
    qcModel model;
    model.positions.assign(soup.positions, soup.positions + 3 * size_t(soup.vertexCount));
    model.indices.assign(soup.indices, soup.indices + 3 * size_t(soup.triangleCount));
    qcSoup_Free(&soup);
    return model;
}

#endif
